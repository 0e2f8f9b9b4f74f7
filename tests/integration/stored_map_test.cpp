// Relocalize, and sessions that localize in stored maps and extend them, through the whole service with real
// SLAM.
#include <atomic>
#include <thread>

#include "room_fixture.h"

namespace semmap {
namespace {

constexpr int kMapFrames = 22;
constexpr int kFarFrames = 34;
// Of a pose against the truth, metres: the map's own error, and a little.
constexpr double kBound = 0.06;

class StoredMapTest : public RoomTest {
 protected:
  void SetUp() override {
    StartRealServer();
    ASSERT_EQ(Drive(v1::SESSION_MODE_MAP, "room", 0, kMapFrames), kMapFrames);
  }

  absl::StatusOr<v1::RelocalizeResponse> Relocalize(int picture, bool stereo) {
    return RoomTest::Relocalize("room", picture, stereo);
  }

  v1::Map TheMap() { return client::Client(Connect()).GetMap("room").value(); }
};

TEST_F(StoredMapTest, APictureIsFoundWithOneEyeAndWithTwo) {
  for (const bool stereo : {false, true}) {
    for (int picture = 1; picture < kMapFrames; picture += 5) {
      const auto response = Relocalize(picture, stereo);
      ASSERT_TRUE(response.ok()) << response.status();
      ASSERT_EQ(response->result(), v1::RELOCALIZE_RESULT_FOUND) << picture;
      EXPECT_LT(Error(response->map_from_camera(), picture), kBound) << picture;
      EXPECT_EQ(response->covariance().upper_triangle_size(), 21);
      EXPECT_GE(response->inliers(), 50);
      EXPECT_FALSE(response->keyframe_ids().empty());
      EXPECT_EQ(response->map_version(), TheMap().version());
      EXPECT_GT(response->processing_ms(), 0);
    }
  }
}

TEST_F(StoredMapTest, AnswersAreTheSameAfterARestart) {
  const auto before = Relocalize(7, true);
  ASSERT_TRUE(before.ok()) << before.status();
  StartRealServer();
  const auto after = Relocalize(7, true);
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_EQ(before->map_from_camera().SerializeAsString(), after->map_from_camera().SerializeAsString());
  EXPECT_EQ(before->inliers(), after->inliers());
}

TEST_F(StoredMapTest, APictureOfNothingIsAnAnswer) {
  v1::RelocalizeRequest request;
  request.set_map("room");
  *request.mutable_rig() = RoomRig(v1::SENSOR_TYPE_MONO);
  *request.mutable_frame()->mutable_image() = GreyImage(480, 320);
  const auto response = client::Client(Connect()).Relocalize(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->result(), v1::RELOCALIZE_RESULT_TOO_FEW_FEATURES);
  request.set_map("nowhere");
  EXPECT_EQ(client::ErrorReason(client::Client(Connect()).Relocalize(request).status()), "MAP_NOT_FOUND");
}

TEST_F(StoredMapTest, ManyAskAtOnce) {
  std::vector<std::thread> callers;
  std::atomic<int> found = 0;
  constexpr int kStride = 8;
  for (int i = 0; i < kStride / 2; ++i) {
    callers.emplace_back([&, i] {
      for (int picture = i; picture < kMapFrames; picture += kStride) {
        const auto response = Relocalize(picture, true);
        found += response.ok() && response->result() == v1::RELOCALIZE_RESULT_FOUND &&
                         Error(response->map_from_camera(), picture) < kBound
                     ? 1
                     : 0;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(found, 12) << "pictures 0 to 3, 8 to 11 and 16 to 19";
}

TEST_F(StoredMapTest, LocalizingNeverChangesTheMap) {
  const v1::Map before = TheMap();
  for (const bool stereo : {true, false}) {
    EXPECT_EQ(Drive(v1::SESSION_MODE_LOCALIZE, "room", 4, 18, stereo), 14) << stereo;
    const auto estimates = recorder_->estimates();
    ASSERT_EQ(estimates.size(), 14U);
    for (size_t i = 0; i < estimates.size(); ++i) {
      EXPECT_LT(Error(estimates[i].map_from_camera(), static_cast<int>(i) + 4), kBound) << i;
      EXPECT_EQ(estimates[i].reference_frame(), v1::REFERENCE_FRAME_MAP);
    }
    EXPECT_EQ(session_.last_acknowledged_sequence(), 14U);
  }
  const v1::Map after = TheMap();
  EXPECT_EQ(after.version(), before.version());
  EXPECT_EQ(after.keyframe_count(), before.keyframe_count());
  EXPECT_EQ(after.point_count(), before.point_count());
  EXPECT_EQ(StoredFrames("maps/room").size(), static_cast<size_t>(kMapFrames + 2 * 14));
}

TEST_F(StoredMapTest, ExtendingAddsToTheMap) {
  const v1::Map before = TheMap();
  // The first frame is found after it was answered.
  EXPECT_GE(Drive(v1::SESSION_MODE_EXTEND, "room", 10, kFarFrames), kFarFrames - 10 - 1);
  const auto estimates = recorder_->estimates();
  for (size_t i = 1; i < estimates.size(); ++i)
    EXPECT_LT(Error(estimates[i].map_from_camera(), static_cast<int>(i) + 10), kBound) << i;
  const v1::Map after = TheMap();
  EXPECT_GT(after.version(), before.version());
  EXPECT_GT(after.keyframe_count(), before.keyframe_count());
  EXPECT_GT(after.point_count(), before.point_count());
  const auto check = client::Client(Connect()).CheckMap("room", nullptr);
  ASSERT_TRUE(check.ok()) << check.status();
  EXPECT_EQ(check->problems_size(), 0) << check->DebugString();
  // Places beyond the old end are in the map now.
  const auto response = Relocalize(kFarFrames - 2, true);
  ASSERT_TRUE(response.ok()) << response.status();
  ASSERT_EQ(response->result(), v1::RELOCALIZE_RESULT_FOUND);
  EXPECT_LT(Error(response->map_from_camera(), kFarFrames - 2), kBound);
}

TEST_F(StoredMapTest, OneChangesAMapAtATime) {
  auto first = client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_EXTEND, "room"), {});
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_EXTEND, "room"), {});
  EXPECT_EQ(client::ErrorReason(second.status()), "MAP_IN_USE");
  EXPECT_EQ(Drive(v1::SESSION_MODE_LOCALIZE, "room", 4, 8), 4) << "beside it one may look";
  EXPECT_TRUE((*first)->Finish().ok());
}

TEST_F(StoredMapTest, WhoLooksInTheWrongMapIsLostAndTold) {
  recorder_ = std::make_unique<Recorder>();
  auto drive = client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_LOCALIZE, "room", false),
                                    recorder_->Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  v1::Frame frame = FrameOf(0, 1, false);
  *frame.mutable_image() = GreyImage(480, 320);
  ASSERT_TRUE((*drive)->Send(frame).ok());
  ASSERT_TRUE((*drive)->Finish().ok());
  ASSERT_EQ(recorder_->estimates().size(), 1U);
  EXPECT_EQ(recorder_->estimates()[0].state(), v1::TRACKING_STATE_LOST);
  EXPECT_EQ(recorder_->estimates()[0].lost_because(), v1::RELOCALIZE_RESULT_NO_CANDIDATES);
}

}  // namespace
}  // namespace semmap
