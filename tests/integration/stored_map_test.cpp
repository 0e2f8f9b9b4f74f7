// Relocalize, and sessions that localize in stored maps and extend them, through the whole service with real
// SLAM.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "client/cli/session_trajectory.h"
#include "room_fixture.h"

namespace semmap {
namespace {

constexpr int kMapFrames = 22;
constexpr int kFarFrames = 34;

class StoredMapTest : public RoomTest {
 protected:
  void SetUp() override {
    StartRealServer();
    ASSERT_EQ(Drive(v1::SESSION_MODE_MAP, "room", 0, kMapFrames), kMapFrames);
  }

  static v1::RelocalizeRequest RequestFor(int picture, bool stereo) {
    return RoomTest::RequestFor("room", picture, stereo);
  }
  absl::StatusOr<v1::RelocalizeResponse> Relocalize(int picture, bool stereo) {
    return RoomTest::Relocalize("room", picture, stereo);
  }

  // The greatest of any number of two poses.
  static double Difference(const v1::Pose& a, const v1::Pose& b) {
    const v1::Vector3& p = a.translation();
    const v1::Vector3& q = b.translation();
    const v1::Quaternion& r = a.rotation();
    const v1::Quaternion& s = b.rotation();
    return std::max({std::abs(p.x() - q.x()), std::abs(p.y() - q.y()), std::abs(p.z() - q.z()),
                     std::abs(r.x() - s.x()), std::abs(r.y() - s.y()), std::abs(r.z() - s.z()),
                     std::abs(r.w() - s.w())});
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

TEST_F(StoredMapTest, AHundredAnswersAreTheSameAfterARestart) {
  constexpr int kPictures = 25;
  const auto ask_all = [this] {
    std::vector<v1::RelocalizeResponse> answers;
    for (int i = 0; i < 4 * kPictures; ++i) {
      v1::RelocalizeRequest request = RequestFor(i / 4, i % 2 == 0);
      if (i % 4 > 1) {
        request.mutable_prior()->mutable_heading_in_map()->set_z(1);
        request.mutable_prior()->set_heading_tolerance_rad(1);
      }
      auto response = client::Client(Connect()).Relocalize(request);
      EXPECT_TRUE(response.ok()) << response.status();
      answers.push_back(response.value_or(v1::RelocalizeResponse()));
    }
    return answers;
  };
  const std::vector<v1::RelocalizeResponse> before = ask_all();
  StartRealServer();
  const std::vector<v1::RelocalizeResponse> after = ask_all();
  int found = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].result(), after[i].result()) << i;
    EXPECT_EQ(before[i].inliers(), after[i].inliers()) << i;
    EXPECT_LT(Difference(before[i].map_from_camera(), after[i].map_from_camera()), 1e-9) << i;
    found += before[i].result() == v1::RELOCALIZE_RESULT_FOUND ? 1 : 0;
  }
  EXPECT_GE(found, 4 * kMapFrames) << "beyond the map's end some are not";
}

TEST_F(StoredMapTest, AnAnchoredMapIsAskedAndAnswersOnEarth) {
  v1::Map anchored = TheMap();
  v1::GeoAnchor* anchor = anchored.mutable_anchor();
  anchor->mutable_origin()->set_latitude_deg(48);
  anchor->mutable_origin()->set_longitude_deg(11);
  anchor->mutable_origin()->set_altitude_m(500);
  // Half a turn about the map's x: its z, along which vehicles drive, is down, y south.
  anchor->mutable_enu_from_map()->mutable_pose()->mutable_rotation()->set_x(1);
  ASSERT_TRUE(client::Client(Connect()).UpdateMap(anchored, {"anchor"}).ok());
  v1::RelocalizeRequest request = RequestFor(15, true);
  auto response = client::Client(Connect()).Relocalize(request);
  ASSERT_TRUE(response.ok()) << response.status();
  ASSERT_TRUE(response->has_geo_position());
  const v1::GeoPosition found = response->geo_position();
  EXPECT_NEAR(found.altitude_m(), 500 - response->map_from_camera().translation().z(), 1e-3);
  EXPECT_NEAR(found.latitude_deg(), 48, 1e-4);

  *request.mutable_prior()->mutable_geo_position() = found;
  request.mutable_prior()->set_radius_m(0.5);
  response = client::Client(Connect()).Relocalize(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->result(), v1::RELOCALIZE_RESULT_FOUND);
  request.mutable_prior()->mutable_geo_position()->set_altitude_m(found.altitude_m() + 1);
  EXPECT_EQ(client::Client(Connect()).Relocalize(request)->result(), v1::RELOCALIZE_RESULT_NO_CANDIDATES);
  request.mutable_prior()->mutable_geo_position()->clear_altitude_m();
  EXPECT_EQ(client::Client(Connect()).Relocalize(request)->result(), v1::RELOCALIZE_RESULT_FOUND);
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
  ExpectSound("room");
  // Places beyond the old end are in the map now.
  ExpectFound("room", kFarFrames - 2);
}

TEST_F(StoredMapTest, TwoExtendItAtOnceAndAThirdLooks) {
  const v1::Map before = TheMap();
  auto first = client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_EXTEND, "room"), {});
  ASSERT_TRUE(first.ok()) << first.status();
  auto second = client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_EXTEND, "room"), {});
  ASSERT_TRUE(second.ok()) << second.status();
  uint64_t sequence = 0;
  // One goes beyond the map's end, the other comes back from there.
  for (int i = 8; i < kFarFrames; ++i) {
    ++sequence;
    ASSERT_TRUE((*first)->Send(FrameOf(i, sequence, true)).ok());
    if (i == 12) {
      EXPECT_EQ(Drive(v1::SESSION_MODE_LOCALIZE, "room", 4, 8), 4);
    }
    ASSERT_TRUE((*second)->Send(FrameOf(kFarFrames + 7 - i, sequence, true)).ok());
  }
  const auto first_summary = (*first)->Finish();
  ASSERT_TRUE(first_summary.ok()) << first_summary.status();
  const auto second_summary = (*second)->Finish();
  ASSERT_TRUE(second_summary.ok()) << second_summary.status();
  EXPECT_GE(first_summary->session().statistics().frames_tracked(), sequence - 2);
  EXPECT_GT(second_summary->session().statistics().frames_tracked(), sequence / 2);
  EXPECT_GT(TheMap().keyframe_count(), before.keyframe_count());
  ExpectSound("room");
  ExpectFound("room", kFarFrames - 2);
}

TEST_F(StoredMapTest, ASecondVehicleJoinsWhileTheFirstMaps) {
  auto maker = client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_MAP, "both"), {});
  ASSERT_TRUE(maker.ok()) << maker.status();
  uint64_t sequence = 0;
  for (int i = 0; i < 12; ++i) ASSERT_TRUE((*maker)->Send(FrameOf(i, ++sequence, true)).ok());
  // There is something to join as soon as the first keyframe is stored.
  absl::StatusOr<std::unique_ptr<client::Drive>> joiner = absl::UnknownError("not tried");
  for (int tries = 0; tries < 100 && !joiner.ok(); ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    joiner = client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_EXTEND, "both"), {});
  }
  ASSERT_TRUE(joiner.ok()) << joiner.status();
  for (int i = 12; i < kMapFrames; ++i) {
    ASSERT_TRUE((*maker)->Send(FrameOf(i, ++sequence, true)).ok());
    ASSERT_TRUE((*joiner)->Send(FrameOf(i - 6, sequence, true)).ok());
  }
  const auto made = (*maker)->Finish();
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->session().statistics().frames_tracked(), static_cast<uint64_t>(kMapFrames));
  const auto joined = (*joiner)->Finish();
  ASSERT_TRUE(joined.ok()) << joined.status();
  EXPECT_GE(joined->session().statistics().frames_tracked(), static_cast<uint64_t>(kMapFrames - 12 - 2));
  ExpectSound("both");
}

TEST_F(StoredMapTest, AVehicleThatBeginsElsewhereBringsItsOwnPiece) {
  constexpr int kDegreesPerFrame = 4;
  recorder_ = std::make_unique<Recorder>();
  auto drive =
      client::Drive::Start(Connect(), OptionsFor(v1::SESSION_MODE_EXTEND, "room"), recorder_->Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  // It looks at the wall behind the map's pictures, turns round, and drives on.
  uint64_t sequence = 0;
  for (int degrees = 180; degrees > 0; degrees -= kDegreesPerFrame)
    ASSERT_TRUE((*drive)->Send(FrameAt(testing::LookAround(degrees), ++sequence)).ok());
  const uint64_t turned = sequence;
  for (int picture = 4; picture < kFarFrames; ++picture)
    ASSERT_TRUE((*drive)->Send(FrameOf(picture, ++sequence, true)).ok());
  const auto summary = (*drive)->Finish();
  ASSERT_TRUE(summary.ok()) << summary.status();

  const auto estimates = recorder_->estimates();
  ASSERT_EQ(estimates.size(), sequence);
  EXPECT_EQ(estimates.front().state(), v1::TRACKING_STATE_TRACKING);
  EXPECT_EQ(estimates.front().reference_frame(), v1::REFERENCE_FRAME_SESSION);
  EXPECT_EQ(estimates.front().map_version(), 0U);
  EXPECT_EQ(estimates.back().reference_frame(), v1::REFERENCE_FRAME_MAP);
  EXPECT_LT(Error(estimates.back().map_from_camera(), kFarFrames - 1), kBound);
  // The stored trajectory begins with the piece, and is all of one frame.
  client::Client client(Connect());
  const auto sessions = client::FetchTrajectories(client, "room", "");
  ASSERT_TRUE(sessions.ok()) << sessions.status();
  const client::SequencedPoses& stored = sessions->at(summary->session().name());
  EXPECT_GT(stored.size(), sequence * 3 / 4);
  const SE3 map_from_world = testing::GentleDrive(1, kStep).front().Inverse();
  int of_piece = 0;
  for (const auto& [of, pose] : stored) {
    if (of >= turned) continue;
    const SE3 truth =
        map_from_world * testing::LookAround(180 - kDegreesPerFrame * (static_cast<double>(of) - 1));
    EXPECT_LT((pose.map_from_camera.translation() - truth.translation()).norm(), 2 * kBound) << of;
    ++of_piece;
  }
  EXPECT_GT(of_piece, 20);
  ExpectSound("room");
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
