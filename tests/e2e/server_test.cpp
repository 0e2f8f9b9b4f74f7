// The real server, as a process of its own, with the real SLAM on real frames.
#include <algorithm>
#include <map>
#include <thread>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/drive.h"
#include "client/errors.h"
#include "kitti_frames.h"
#include "server_process.h"
#include "slam/common/mutex.h"

namespace semmap {
namespace {

class ServerE2eTest : public testing::Test {
 protected:
  ServerE2eTest() {
    std::string path = (std::filesystem::temp_directory_path() / "semmap-e2e-XXXXXX").string();
    data_ = mkdtemp(path.data());
  }
  ~ServerE2eTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(data_, ignored);
  }
  void SetUp() override {
    if (!frames_.available()) GTEST_SKIP() << "no data at " << frames_.folder() << "; set SEMMAP_SHARED";
  }

  static std::string ConfigFile(const char* name) {
    return std::string(SEMMAP_SOURCE_DIR) + "/config/" + name;
  }

  static std::shared_ptr<client::Connection> Connect(const ServerProcess& server) {
    client::ConnectOptions options;
    options.address = server.address();
    auto connection = client::Connection::Open(options);
    EXPECT_TRUE(connection.ok()) << connection.status();
    return connection.value_or(nullptr);
  }

  client::DriveOptions OptionsFor(const std::string& map, v1::SensorType sensor) const {
    client::DriveOptions options;
    options.vehicle_id = "car";
    options.map = map;
    options.rig = frames_.Rig(sensor);
    options.send_timeout = std::chrono::minutes(2);
    return options;
  }

  // Drives frames 0 to count - 1 and returns their answers, timing left out: what must be the same in every
  // run.
  std::vector<std::string> Drive(const ServerProcess& server, const std::string& map, v1::SensorType sensor,
                                 int count) {
    std::vector<std::string> answers;
    client::DriveObserver observer;
    observer.on_estimate = [&](v1::FrameEstimate estimate) {
      estimate.clear_times();
      answers.push_back(estimate.SerializeAsString());
    };
    auto drive = client::Drive::Start(Connect(server), OptionsFor(map, sensor), observer);
    EXPECT_TRUE(drive.ok()) << drive.status();
    if (!drive.ok()) return {};
    for (int i = 0; i < count; ++i) EXPECT_TRUE((*drive)->Send(frames_.Frame(i, sensor)).ok());
    const auto summary = (*drive)->Finish();
    EXPECT_TRUE(summary.ok()) << summary.status();
    return answers;
  }

  static std::vector<uint64_t> StoredFrames(client::Client& client, const std::string& map) {
    std::vector<uint64_t> sequences;
    v1::GetTrajectoryRequest request;
    request.set_map(map);
    const absl::Status status = client.GetTrajectory(request, [&](const v1::GetTrajectoryResponse& response) {
      const auto& columns = response.trajectory();
      sequences.insert(sequences.end(), columns.sequences().begin(), columns.sequences().end());
      return true;
    });
    EXPECT_TRUE(status.ok()) << status;
    return sequences;
  }

  KittiFrames frames_{"kitti06_stereo51"};
  std::string data_;
};

TEST_F(ServerE2eTest, AMapOutlivesTheServer) {
  int tracked = 0;
  {
    ServerProcess server(ConfigFile("semmapd.yaml"), data_);
    ASSERT_FALSE(server.address().empty());
    for (const std::string& answer : Drive(server, "street", v1::SENSOR_TYPE_STEREO, 51)) {
      v1::FrameEstimate estimate;
      ASSERT_TRUE(estimate.ParseFromString(answer));
      tracked += estimate.state() == v1::TRACKING_STATE_TRACKING ? 1 : 0;
    }
    EXPECT_GE(tracked, 50);
    EXPECT_EQ(server.Stop(SIGTERM), 0);
  }
  ServerProcess server(ConfigFile("semmapd.yaml"), data_);
  client::Client client(Connect(server));
  const auto summary = client.GetMapSummary("street");
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->frame_count(), tracked);
  EXPECT_GT(summary->map().point_count(), 1000);
  EXPECT_GE(summary->map().keyframe_count(), 5);
  // KITTI 06 drives 59.9 m in these frames.
  EXPECT_NEAR(summary->trajectory_length_m(), 59.9, 1.5);
  EXPECT_EQ(StoredFrames(client, "street").size(), static_cast<size_t>(tracked));
  int points = 0;
  v1::QueryMapPointsRequest request;
  request.set_map("street");
  EXPECT_TRUE(client
                  .QueryMapPoints(request,
                                  [&](const auto& message) {
                                    points += message.points().ids_size();
                                    return true;
                                  })
                  .ok());
  EXPECT_EQ(points, summary->map().point_count());
}

TEST_F(ServerE2eTest, StoppedInTheMiddleItStoresWhatWasAnswered) {
  ServerProcess server(ConfigFile("semmapd.yaml"), data_);
  Mutex mutex;
  std::vector<uint64_t> tracked;
  client::DriveObserver observer;
  observer.on_estimate = [&](const v1::FrameEstimate& estimate) {
    MutexLock lock(&mutex);
    if (estimate.state() == v1::TRACKING_STATE_TRACKING) tracked.push_back(estimate.sequence());
  };
  client::DriveOptions options = OptionsFor("street", v1::SENSOR_TYPE_STEREO);
  auto drive = client::Drive::Start(Connect(server), options, observer);
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE((*drive)->Send(frames_.Frame(i, v1::SENSOR_TYPE_STEREO)).ok());
  EXPECT_EQ(server.Stop(SIGTERM), 0);
  const absl::Status status = (*drive)->Send(frames_.Frame(20, v1::SENSOR_TYPE_STEREO));
  EXPECT_EQ(client::ErrorReason(status), "SHUTTING_DOWN") << status;
  drive->reset();

  ServerProcess again(ConfigFile("semmapd.yaml"), data_);
  client::Client client(Connect(again));
  const std::vector<uint64_t> stored = StoredFrames(client, "street");
  EXPECT_GE(tracked.size(), 12U);  // twenty less the window
  EXPECT_TRUE(std::includes(stored.begin(), stored.end(), tracked.begin(), tracked.end()));
}

TEST_F(ServerE2eTest, KilledItKeepsWhatItAcknowledged) {
  Mutex mutex;
  uint64_t acknowledged = 0;
  std::vector<uint64_t> tracked;
  client::DriveObserver observer;
  observer.on_acknowledgement = [&](const v1::Acknowledgement& acknowledgement) {
    MutexLock lock(&mutex);
    acknowledged = acknowledgement.sequence();
  };
  observer.on_estimate = [&](const v1::FrameEstimate& estimate) {
    MutexLock lock(&mutex);
    if (estimate.state() == v1::TRACKING_STATE_TRACKING) tracked.push_back(estimate.sequence());
  };
  std::string session;
  {
    ServerProcess server(ConfigFile("semmapd.yaml"), data_);
    client::DriveOptions options = OptionsFor("street", v1::SENSOR_TYPE_STEREO);
    options.resume = false;
    auto drive = client::Drive::Start(Connect(server), options, observer);
    ASSERT_TRUE(drive.ok()) << drive.status();
    session = (*drive)->started().session();
    for (int i = 0; i < 30; ++i) ASSERT_TRUE((*drive)->Send(frames_.Frame(i, v1::SENSOR_TYPE_STEREO)).ok());
    ASSERT_TRUE((*drive)->WaitForAnswers(std::chrono::minutes(1)).ok());
    EXPECT_FALSE(server.Stop(SIGKILL).has_value());
    EXPECT_FALSE((*drive)->Finish().ok());
  }
  ServerProcess server(ConfigFile("semmapd.yaml"), data_);
  client::Client client(Connect(server));
  ASSERT_GT(acknowledged, 5U);
  const std::vector<uint64_t> stored = StoredFrames(client, "street");
  for (const uint64_t sequence : tracked) {
    if (sequence > acknowledged) continue;
    EXPECT_TRUE(std::binary_search(stored.begin(), stored.end(), sequence)) << sequence;
  }
  const auto after = client.GetSession(session);
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_EQ(after->state(), v1::SESSION_STATE_ABANDONED);
  EXPECT_GE(after->last_acknowledged_sequence(), acknowledged);
}

TEST_F(ServerE2eTest, DeterministicTogetherAsAlone) {
  constexpr int kFrames = 20;
  ServerProcess server(ConfigFile("semmapd-deterministic.yaml"), data_);
  const auto stereo = Drive(server, "stereo", v1::SENSOR_TYPE_STEREO, kFrames);
  const auto mono = Drive(server, "mono", v1::SENSOR_TYPE_MONO, kFrames);
  ASSERT_EQ(stereo.size(), static_cast<size_t>(kFrames));
  std::vector<std::vector<std::string>> together(4);
  std::vector<std::thread> vehicles;
  for (size_t i = 0; i < together.size(); ++i) {
    vehicles.emplace_back([&, i] {
      const v1::SensorType sensor = i % 2 == 0 ? v1::SENSOR_TYPE_STEREO : v1::SENSOR_TYPE_MONO;
      together[i] = Drive(server, "together" + std::to_string(i), sensor, kFrames);
    });
  }
  for (std::thread& vehicle : vehicles) vehicle.join();
  EXPECT_EQ(together[0], stereo);
  EXPECT_EQ(together[1], mono);
  EXPECT_EQ(together[2], stereo);
  EXPECT_EQ(together[3], mono);
}

}  // namespace
}  // namespace semmap
