// Frames that come over the wire are segmented by a (tiny) network of the server's: its classes are in the
// store.
#include <functional>
#include <map>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "client/image.h"
#include "service_fixture.h"
#include "slam/place/vocabulary.h"
#include "slam/semantics/torch/torch_segmenter.h"
#include "tests/support/textured_room.h"
#include "tests/support/tiny_network/tiny_network.h"

namespace semmap {
namespace {

constexpr uint32_t kRoad = 7;        // red
constexpr uint32_t kVegetation = 9;  // green
constexpr int kFrames = 10;

// A room whose left half is lit red and whose right half is lit green.
cv::Mat Light(const cv::Mat& grey) {
  cv::Mat colour(grey.size(), CV_8UC3);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const uint8_t value = grey.at<uint8_t>(y, x);
      const auto dim = static_cast<uint8_t>(value / 4);
      colour.at<cv::Vec3b>(y, x) =
          x < grey.cols / 2 ? cv::Vec3b(dim, dim, value) : cv::Vec3b(dim, value, dim);
    }
  }
  return colour;
}

class ServerSegmentationTest : public ServiceTest {
 protected:
  void SetUp() override {
    SegmentationConfig& segmentation = config_.slam.segmentation;
    segmentation.mode = SegmentationMode::kEveryFrame;
    segmentation.model = WriteTinyNetwork(directory_.path(), "tiny", kColourNetwork, "[7, 9, 13]");
    config_.slam.orb.features = 600;
  }

  void StartWithModel() {
    auto queue = LoadSegmentation(config_.slam.segmentation);
    ASSERT_TRUE(queue.ok()) << queue.status();
    queue_ = *queue;
    const auto vocabulary = LoadVocabulary(config_.slam.place);
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    auto server = server::Server::Start(
        config_,
        [queue = *queue, vocabulary = *vocabulary](const SlamConfig& config, const CameraRig& rig,
                                                   MapDeltaSink* sink, Executor* executor,
                                                   SessionStart start) {
          return Session::Create(config, rig, sink, executor, vocabulary, queue, std::move(start));
        },
        *vocabulary, *queue);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::move(server).value();
  }

  static client::DriveOptions RoomDrive() {
    const CameraIntrinsics camera = testing::SmallCamera();
    client::DriveOptions options = DriveTo("room");
    options.rig = Rig(v1::SENSOR_TYPE_RGBD);
    v1::CameraIntrinsics* intrinsics = options.rig.mutable_camera();
    intrinsics->set_width(camera.width);
    intrinsics->set_height(camera.height);
    intrinsics->set_fx(camera.fx);
    intrinsics->set_fy(camera.fy);
    intrinsics->set_cx(camera.cx);
    intrinsics->set_cy(camera.cy);
    return options;
  }

  static v1::Frame RoomFrame(int index) {
    cv::Mat depth;
    const SE3 pose = testing::GentleDrive(kFrames, 0.15)[static_cast<size_t>(index)];
    const cv::Mat grey = testing::TexturedRoom(3).Render(testing::SmallCamera(), pose, &depth);
    v1::Frame frame;
    frame.set_sequence(static_cast<uint64_t>(index + 1));
    frame.set_timestamp_ns(100'000'000LL * index + 1);
    *frame.mutable_image() = client::PngImage(Light(grey)).value();
    *frame.mutable_depth() = client::RawImage(depth).value();
    return frame;
  }

  // Sends the room; `change` may add to each frame.
  v1::Session DriveThroughRoom(
      const std::function<void(v1::Frame*)>& change = [](v1::Frame*) {},
      v1::OverloadPolicy policy = v1::OVERLOAD_POLICY_BLOCK) {
    client::DriveOptions options = RoomDrive();
    options.overload_policy = policy;
    auto drive = client::Drive::Start(Connect(), options, {});
    EXPECT_TRUE(drive.ok()) << drive.status();
    if (!drive.ok()) return {};
    for (int i = 0; i < kFrames; ++i) {
      v1::Frame frame = RoomFrame(i);
      change(&frame);
      EXPECT_TRUE((*drive)->Send(std::move(frame)).ok());
      // So that none is dropped.
      EXPECT_TRUE((*drive)->WaitForAnswers(std::chrono::seconds(20)).ok());
    }
    const auto summary = (*drive)->Finish();
    EXPECT_TRUE(summary.ok()) << summary.status();
    return summary.ok() ? summary->session() : v1::Session();
  }

  // How many stored points have each class.
  std::map<uint32_t, int> StoredClasses() {
    std::map<uint32_t, int> counts;
    v1::QueryMapPointsRequest request;
    request.set_map("maps/room");
    const absl::Status status =
        client::Client(Connect()).QueryMapPoints(request, [&](const v1::QueryMapPointsResponse& response) {
          for (const uint32_t id : response.points().semantic_classes()) ++counts[id];
          return true;
        });
    EXPECT_TRUE(status.ok()) << status;
    return counts;
  }

  std::shared_ptr<SegmentationQueue> queue_;
};

TEST_F(ServerSegmentationTest, EveryFrameOfAVehicleIsSegmented) {
  StartWithModel();
  const v1::Session session = DriveThroughRoom();
  EXPECT_EQ(session.statistics().frames_tracked(), static_cast<uint64_t>(kFrames));
  EXPECT_EQ(session.statistics().frames_classified(), static_cast<uint64_t>(kFrames));
  EXPECT_EQ(session.statistics().frames_unclassified(), 0U);
  const std::map<uint32_t, int> classes = StoredClasses();
  ASSERT_EQ(classes.size(), 2U);
  EXPECT_GT(classes.at(kRoad), 50);
  EXPECT_GT(classes.at(kVegetation), 50);
}

TEST_F(ServerSegmentationTest, KeyFramesAlone) {
  config_.slam.segmentation.mode = SegmentationMode::kKeyFrames;
  StartWithModel();
  const v1::Session session = DriveThroughRoom();
  EXPECT_EQ(session.statistics().frames_tracked(), static_cast<uint64_t>(kFrames));
  EXPECT_LT(queue_->counts().submitted, static_cast<uint64_t>(kFrames));
  const std::map<uint32_t, int> classes = StoredClasses();
  ASSERT_EQ(classes.size(), 2U);
  EXPECT_GT(classes.at(kRoad), 50);
  EXPECT_GT(classes.at(kVegetation), 50);
}

// A vehicle that would rather lose frames has a mode of its own, and one that waits does not.
TEST_F(ServerSegmentationTest, LiveModeIsForVehiclesThatDoNotWait) {
  constexpr auto kKeep = [](v1::Frame*) {};
  config_.slam.segmentation.live_mode = SegmentationMode::kKeyFrames;
  config_.slam.segmentation.max_wait_ms = 20'000;
  StartWithModel();
  const v1::Session live = DriveThroughRoom(kKeep, v1::OVERLOAD_POLICY_LATEST_WINS);
  EXPECT_EQ(live.statistics().frames_processed(), static_cast<uint64_t>(kFrames));
  EXPECT_GT(queue_->counts().submitted, 0U);
  EXPECT_LT(queue_->counts().submitted, static_cast<uint64_t>(kFrames));
  EXPECT_EQ(StoredClasses().size(), 2U);
  ASSERT_TRUE(client::Client(Connect()).DeleteMap("room").ok());

  config_.slam.segmentation.live_mode = SegmentationMode::kOff;
  server_.reset();
  StartWithModel();
  DriveThroughRoom(kKeep, v1::OVERLOAD_POLICY_LATEST_WINS);
  EXPECT_EQ(queue_->counts().submitted, 0U);
  ASSERT_TRUE(client::Client(Connect()).DeleteMap("room").ok());
  DriveThroughRoom(kKeep, v1::OVERLOAD_POLICY_BLOCK);
  EXPECT_EQ(queue_->counts().submitted, static_cast<uint64_t>(kFrames));
}

TEST_F(ServerSegmentationTest, APictureThatIsLookedForIsSegmented) {
  StartWithModel();
  DriveThroughRoom();
  v1::RelocalizeRequest request;
  request.set_map("room");
  *request.mutable_rig() = RoomDrive().rig;
  *request.mutable_frame() = RoomFrame(kFrames / 2);
  client::Client client(Connect());
  const uint64_t before = queue_->counts().submitted;
  auto response = client.Relocalize(request);
  ASSERT_TRUE(response.ok()) << response.status();
  ASSERT_EQ(response->result(), v1::RELOCALIZE_RESULT_FOUND);
  EXPECT_EQ(queue_->counts().submitted, before + 1);
  EXPECT_GT(response->class_agreement(), 0.9);

  // A mask takes the model's place.
  cv::Mat mask(testing::SmallCamera().height, testing::SmallCamera().width, CV_8UC1, cv::Scalar(kRoad));
  mask.colRange(mask.cols / 2, mask.cols) = kVegetation;
  *request.mutable_frame()->mutable_class_mask() = client::RawImage(mask).value();
  response = client.Relocalize(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->result(), v1::RELOCALIZE_RESULT_FOUND);
  EXPECT_EQ(queue_->counts().submitted, before + 1);
  EXPECT_GT(response->class_agreement(), 0.9);
}

TEST_F(ServerSegmentationTest, AMaskOfTheVehiclesReplacesTheModel) {
  StartWithModel();
  const cv::Mat mask(testing::SmallCamera().height, testing::SmallCamera().width, CV_8UC1, cv::Scalar(11));
  DriveThroughRoom([&](v1::Frame* frame) { *frame->mutable_class_mask() = client::RawImage(mask).value(); });
  const std::map<uint32_t, int> classes = StoredClasses();
  ASSERT_EQ(classes.size(), 1U);
  EXPECT_GT(classes.at(11), 100);
  EXPECT_EQ(queue_->counts().submitted, 0U);
}

}  // namespace
}  // namespace semmap
