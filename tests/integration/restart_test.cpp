#include <thread>

#include "service_fixture.h"

namespace semmap {
namespace {

class RestartTest : public ServiceTest {
 protected:
  void Drive(const std::string& map, uint64_t frames) {
    auto drive = client::Drive::Start(Connect(), DriveTo(map), {});
    ASSERT_TRUE(drive.ok()) << drive.status();
    for (uint64_t sequence = 1; sequence <= frames; ++sequence)
      ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
    ASSERT_TRUE((*drive)->Finish().ok());
  }
};

TEST_F(RestartTest, TheMapsAreStillThere) {
  for (const char* map : {"a", "b", "c", "d"}) Drive(map, 23);
  server_.reset();
  StartServer();
  client::Client client(Connect());
  const auto maps = client.ListMaps();
  ASSERT_TRUE(maps.ok()) << maps.status();
  ASSERT_EQ(maps->size(), 4U);
  for (const v1::Map& map : *maps) {
    EXPECT_EQ(map.keyframe_count(), 5);
    EXPECT_EQ(StoredFrames(map.name()), UpTo(23));
    v1::QueryMapPointsRequest points;
    points.set_map(map.name());
    int count = 0;
    EXPECT_TRUE(client
                    .QueryMapPoints(points,
                                    [&](const auto& message) {
                                      count += message.points().ids_size();
                                      return true;
                                    })
                    .ok());
    EXPECT_EQ(count, 5);
    v1::QueryKeyFramesRequest keyframes;
    keyframes.set_map(map.name());
    keyframes.set_page_size(2);
    count = 0;
    EXPECT_TRUE(client.QueryKeyFrames(keyframes, [&](const v1::KeyFrame&) { return ++count > 0; }).ok());
    EXPECT_EQ(count, 5);
  }
  EXPECT_EQ(client.ListSessions({})->size(), 4U);
}

TEST_F(RestartTest, StoppingStoresWhatIsRunning) {
  Recorder recorder;
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), recorder.Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (uint64_t sequence = 1; sequence <= 8; ++sequence) ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  ASSERT_TRUE((*drive)->WaitForAnswers(std::chrono::seconds(10)).ok());
  std::thread stop([&] { server_->Drain(); });
  absl::Status status;
  for (uint64_t sequence = 9; status.ok() && sequence < 1000; ++sequence) {
    status = (*drive)->Send(Frame(sequence));
    absl::SleepFor(absl::Milliseconds(5));
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(client::ErrorReason(status), "SHUTTING_DOWN");
  stop.join();
  server_.reset();
  StartServer();
  // Everything that was answered is stored.
  EXPECT_EQ(StoredFrames("town"), recorder.answered());
  EXPECT_GE(recorder.answered().size(), 8U);
}

TEST_F(RestartTest, DrainLeavesOutWaitingFramesWhenTimeIsUp) {
  server_.reset();
  config_.server.drain_timeout_s = 1;
  StartServer();
  gate_.Close();
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  ASSERT_TRUE(gate_.WaitForFrames(1));
  std::thread open([&] {
    absl::SleepFor(absl::Milliseconds(850));
    gate_.Open();
  });
  server_->Drain();
  open.join();
  EXPECT_EQ(gate_.seen(), UpTo(1));
}

}  // namespace
}  // namespace semmap
