// The contract of MapStore: what a delta does, and what is refused.
#include <limits>

#include "map_store_contract.h"

namespace semmap::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST_P(MapStoreContract, WhatIsAppliedIsThereAfterReopening) {
  StartSmallMap();
  Reopen();
  const MapDelta expected = SmallDelta();
  const std::vector<KeyFrameEntry> keyframes = AllKeyFrames(*store_, map_, {.with_features = true});
  ASSERT_EQ(keyframes.size(), 3);
  for (size_t i = 0; i < 3; ++i) {
    const KeyFrameRecord& record = keyframes[i].record;
    EXPECT_EQ(record.id, expected.added_keyframes[i].id);
    EXPECT_EQ(record.sequence, expected.added_keyframes[i].sequence);
    EXPECT_EQ(record.timestamp, expected.added_keyframes[i].timestamp);
    EXPECT_EQ(record.parent, expected.added_keyframes[i].parent);
    EXPECT_TRUE(SamePose(record.map_from_camera, expected.added_keyframes[i].map_from_camera));
    ASSERT_NE(record.features, nullptr);
    EXPECT_TRUE(SameFeatures(*record.features, *expected.added_keyframes[i].features));
    EXPECT_EQ(keyframes[i].session, session_);
    EXPECT_EQ(keyframes[i].keypoint_count, 8);
    EXPECT_EQ(keyframes[i].observation_count, i < 2 ? 4 : 0);
    EXPECT_EQ(store_->GetObservations(map_, record.id)->point_of_keypoint,
              expected.observations[i].point_of_keypoint);
  }
  const std::vector<MapPointRecord> points = AllPoints(*store_, map_);
  ASSERT_EQ(points.size(), 4);
  for (size_t i = 0; i < 4; ++i) EXPECT_TRUE(SamePoint(points[i], expected.upserted_points[i]));
  const absl::StatusOr<MapInfo> map = store_->GetMap(map_);
  EXPECT_EQ(map->keyframe_count, 3);
  EXPECT_EQ(map->point_count, 4);
  EXPECT_EQ(map->version, 1);
  EXPECT_EQ(map->last_keyframe_id, KeyFrameId(3));
  EXPECT_EQ(map->last_point_id, MapPointId(4));
  EXPECT_EQ(map->camera_extent.min(), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(map->camera_extent.max(), Eigen::Vector3d(3, 0, 0));
  const absl::StatusOr<SessionInfo> session = store_->GetSession(map_, session_);
  EXPECT_EQ(session->stored_frames, 6);
  EXPECT_EQ(session->last_durable_sequence, 30);
  EXPECT_EQ(session->last_delta_version, 1);
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(MapStoreContract, DeltasAreNeitherLostNorAppliedTwice) {
  StartMap();
  MapDelta delta = SmallDelta();
  delta.version = 0;
  EXPECT_TRUE(absl::IsInvalidArgument(store_->Apply(map_, session_, delta)));
  delta.version = 5;
  ASSERT_TRUE(store_->Apply(map_, session_, delta).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(store_->Apply(map_, session_, delta)));
  MapDelta empty;
  empty.version = 7;
  EXPECT_TRUE(absl::IsFailedPrecondition(store_->Apply(map_, session_, empty)));
  empty.version = 6;
  EXPECT_TRUE(store_->Apply(map_, session_, empty).ok());
  EXPECT_EQ(store_->GetMap(map_)->version, 2);
}

// Who only drives in a map leaves it as it is.
TEST_P(MapStoreContract, FramesAloneLeaveTheVersion) {
  StartSmallMap();
  const uint64_t before = store_->GetMap(map_)->version;
  MapDelta frames;
  frames.frames.push_back({31, 3100, KeyFrameId(3), SE3()});
  ASSERT_TRUE(Apply(frames).ok());
  EXPECT_EQ(store_->GetMap(map_)->version, before);
  EXPECT_EQ(store_->GetSession(map_, session_)->stored_frames, 7);
  frames.frames.front().sequence = 32;
  frames.moved_keyframes.push_back({KeyFrameId(2), SE3(), KeyFrameId(1)});
  ASSERT_TRUE(Apply(frames).ok());
  EXPECT_EQ(store_->GetMap(map_)->version, before + 1);
}

TEST_P(MapStoreContract, PointsAndPosesChange) {
  StartSmallMap();
  MapDelta delta;
  delta.moved_keyframes.push_back(
      {KeyFrameId(2), SE3(Eigen::Quaterniond(0.1, 1, 0, 0), {50, -0.0, 9}), KeyFrameId(3)});
  MapPointRecord point = PointAt(3, {-500, 2, 2}, 13);
  point.observation_count = 2;
  point.first_seen = -4;
  point.last_seen = 1000;
  point.votes.clear();
  delta.upserted_points.push_back(point);
  ASSERT_TRUE(Apply(delta).ok());
  EXPECT_TRUE(SamePoint(AllPoints(*store_, map_).at(2), point));
  const absl::StatusOr<KeyFrameEntry> keyframe = store_->GetKeyFrame(map_, KeyFrameId(2));
  EXPECT_TRUE(SamePose(keyframe->record.map_from_camera, delta.moved_keyframes[0].map_from_camera));
  EXPECT_EQ(keyframe->record.parent, KeyFrameId(3));
  MapPointQuery query;
  query.box = Eigen::AlignedBox3d(Eigen::Vector3d(-501, 0, 0), Eigen::Vector3d(-499, 3, 3));
  EXPECT_THAT(PointIds(*store_, map_, query), ElementsAre(3));
  query.box = Eigen::AlignedBox3d(Eigen::Vector3d(29, 0, -2), Eigen::Vector3d(31, 3, 3));
  EXPECT_THAT(PointIds(*store_, map_, query), IsEmpty());
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(MapStoreContract, CulledKeyFrameLeavesItsFramesAndChildrenToTheHeir) {
  StartSmallMap();
  MapDelta adopt;
  adopt.moved_keyframes.push_back({KeyFrameId(3), SE3(), KeyFrameId(2)});
  ASSERT_TRUE(Apply(adopt).ok());
  const std::vector<TrajectoryPose> before = Trajectory(*store_, map_);
  const SE3 map_from_removed = store_->GetKeyFrame(map_, KeyFrameId(2))->record.map_from_camera;
  const SE3 map_from_heir = store_->GetKeyFrame(map_, KeyFrameId(1))->record.map_from_camera;

  MapDelta cull;
  cull.removed_keyframes.push_back(
      {KeyFrameId(2), KeyFrameId(1), map_from_heir.Inverse() * map_from_removed});
  for (MapPointRecord point : SmallDelta().upserted_points) {
    point.observation_count = 1;
    cull.upserted_points.push_back(point);
  }
  ASSERT_TRUE(Apply(cull).ok());
  EXPECT_THAT(KeyFrameIds(*store_, map_), ElementsAre(1, 3));
  EXPECT_EQ(store_->GetKeyFrame(map_, KeyFrameId(3))->record.parent, KeyFrameId(1));
  EXPECT_TRUE(absl::IsNotFound(store_->GetKeyFrame(map_, KeyFrameId(2)).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->GetObservations(map_, KeyFrameId(2)).status()));
  const std::vector<TrajectoryPose> after = Trajectory(*store_, map_);
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) {
    EXPECT_NE(after[i].reference_keyframe, KeyFrameId(2));
    const SE3 difference = before[i].map_from_camera.Inverse() * after[i].map_from_camera;
    EXPECT_LT(difference.Log().norm(), 1e-12) << i;
  }
  EXPECT_EQ(Findings(*store_, map_), "");

  // From now on the frames move with the heir.
  MapDelta move;
  move.moved_keyframes.push_back(
      {KeyFrameId(1), SE3(Eigen::Quaterniond::Identity(), {100, 0, 0}), KeyFrameId()});
  ASSERT_TRUE(Apply(move).ok());
  EXPECT_NEAR(Trajectory(*store_, map_)[2].map_from_camera.translation().x(), 100, 10);
}

TEST_P(MapStoreContract, FramesKeepTheirDistanceInTheNewUnitOfTheirKeyFrame) {
  StartSmallMap();
  const std::vector<TrajectoryPose> before = Trajectory(*store_, map_);
  const SE3 keyframe = store_->GetKeyFrame(map_, KeyFrameId(2))->record.map_from_camera;
  MapDelta loop;
  loop.moved_keyframes.push_back({KeyFrameId(2), keyframe, KeyFrameId(1), 1.5});
  ASSERT_TRUE(Apply(loop).ok());
  const std::vector<TrajectoryPose> after = Trajectory(*store_, map_);
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) {
    const bool hangs_on_it = before[i].reference_keyframe == KeyFrameId(2);
    const Eigen::Vector3d offset = before[i].map_from_camera.translation() - keyframe.translation();
    const Eigen::Vector3d expected =
        before[i].map_from_camera.translation() + (hangs_on_it ? 0.5 : 0.0) * offset;
    EXPECT_LT((after[i].map_from_camera.translation() - expected).norm(), 1e-12) << i;
  }
}

TEST_P(MapStoreContract, HeirThatWasAChildTakesTheParentOfTheRemoved) {
  StartSmallMap();
  MapDelta cull;
  cull.removed_keyframes.push_back({KeyFrameId(1), KeyFrameId(3), SE3()});
  for (MapPointRecord point : SmallDelta().upserted_points) {
    point.observation_count = 1;
    point.reference_keyframe = KeyFrameId(2);
    cull.upserted_points.push_back(point);
  }
  ASSERT_TRUE(Apply(cull).ok());
  EXPECT_FALSE(store_->GetKeyFrame(map_, KeyFrameId(3))->record.parent.IsValid());
  EXPECT_EQ(store_->GetKeyFrame(map_, KeyFrameId(2))->record.parent, KeyFrameId(3));
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(MapStoreContract, KeyFrameAddedAndCulledInOneDelta) {
  StartMap();
  MapDelta delta = SmallDelta();
  delta.removed_keyframes.push_back({KeyFrameId(3), KeyFrameId(2), SE3()});
  delta.frames.resize(4);  // those of keyframe 3 would come too late
  ASSERT_TRUE(Apply(delta).ok());
  EXPECT_THAT(KeyFrameIds(*store_, map_), ElementsAre(1, 2));
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(MapStoreContract, RemovedPointsAreGone) {
  StartSmallMap();
  MapDelta delta;
  delta.removed_points = {MapPointId(2), MapPointId(77)};
  for (const uint64_t id : {1, 2}) {
    KeyFrameObservations observations = *store_->GetObservations(map_, KeyFrameId(id));
    observations.point_of_keypoint[2] = MapPointId();
    delta.observations.push_back(observations);
  }
  ASSERT_TRUE(Apply(delta).ok());
  EXPECT_THAT(PointIds(*store_, map_), ElementsAre(1, 3, 4));
  EXPECT_EQ(store_->GetMap(map_)->point_count, 3);
  EXPECT_EQ(store_->GetKeyFrame(map_, KeyFrameId(1))->observation_count, 3);
  MapPointQuery query;
  query.box = Eigen::AlignedBox3d(Eigen::Vector3d(19, 0, -2), Eigen::Vector3d(21, 3, 3));
  EXPECT_THAT(PointIds(*store_, map_, query), IsEmpty());
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(MapStoreContract, ResetForgetsThenApplies) {
  StartSmallMap();
  MapDelta delta;
  delta.reset = true;
  delta.added_keyframes.push_back(KeyFrameWith(4, 2));
  delta.frames.push_back({100, 1, KeyFrameId(4), SE3()});
  ASSERT_TRUE(Apply(delta).ok());
  EXPECT_THAT(KeyFrameIds(*store_, map_), ElementsAre(4));
  EXPECT_THAT(PointIds(*store_, map_), IsEmpty());
  EXPECT_EQ(Trajectory(*store_, map_).size(), 1);
  const absl::StatusOr<MapInfo> map = store_->GetMap(map_);
  EXPECT_EQ(map->keyframe_count, 1);
  EXPECT_EQ(map->point_count, 0);
  EXPECT_EQ(map->last_point_id, MapPointId(4));  // ids are not used again
  EXPECT_EQ(store_->GetSession(map_, session_)->stored_frames, 1);
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(MapStoreContract, ResetForgetsOnlyItsOwnSession) {
  StartSmallMap();
  const absl::StatusOr<SessionInfo> other = store_->StartSession(SessionOf(map_, "other"));
  MapDelta delta;
  delta.version = 1;
  delta.added_keyframes.push_back(KeyFrameWith(10, 2));
  MapPointRecord point = PointAt(10, {0, 0, 0});
  point.reference_keyframe = KeyFrameId(10);
  delta.upserted_points.push_back(point);
  delta.frames.push_back({0, 1, KeyFrameId(10), SE3()});
  ASSERT_TRUE(store_->Apply(map_, other->id, delta).ok());
  MapDelta reset;
  reset.version = 2;
  reset.reset = true;
  ASSERT_TRUE(store_->Apply(map_, other->id, reset).ok());
  EXPECT_THAT(KeyFrameIds(*store_, map_), ElementsAre(1, 2, 3));
  EXPECT_THAT(PointIds(*store_, map_), ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(Trajectory(*store_, map_).size(), 6);
  // A session that others built on cannot go.
  MapDelta guest;
  guest.version = 3;
  guest.frames.push_back({9, 9, KeyFrameId(1), SE3()});
  ASSERT_TRUE(store_->Apply(map_, other->id, guest).ok());
  MapDelta own;
  own.reset = true;
  ExpectRefused(own, absl::StatusCode::kFailedPrecondition);
}

TEST_P(MapStoreContract, RefusesContradictingDeltasAsAWhole) {
  StartSmallMap();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SE3 bad_pose(Eigen::Quaterniond::Identity(), {nan, 0, 0});
  std::vector<MapDelta> bad;
  bad.emplace_back().added_keyframes = {KeyFrameWith(9, 1), KeyFrameWith(2, 1)};  // 2 exists
  bad.emplace_back().added_keyframes = {KeyFrameWith(0, 1)};
  bad.emplace_back().added_keyframes = {KeyFrameWith(uint64_t{1} << 40, 1)};
  bad.emplace_back().added_keyframes = {KeyFrameWith(9, 1)};
  bad.back().added_keyframes[0].features = nullptr;
  bad.emplace_back().added_keyframes = {KeyFrameWith(9, 1)};
  bad.back().added_keyframes[0].map_from_camera = bad_pose;
  bad.emplace_back().added_keyframes = {KeyFrameWith(9, 1)};
  bad.back().added_keyframes[0].sequence = ~uint64_t{0};
  auto uneven = std::make_shared<FrameFeatures>(*KeyFrameWith(9, 3).features);
  uneven->descriptors.pop_back();
  bad.emplace_back().added_keyframes = {KeyFrameWith(9, 1)};
  bad.back().added_keyframes[0].features = uneven;
  auto infinite = std::make_shared<FrameFeatures>(*KeyFrameWith(9, 3).features);
  infinite->keypoints[1].angle = std::numeric_limits<float>::infinity();
  bad.emplace_back().added_keyframes = {KeyFrameWith(9, 1)};
  bad.back().added_keyframes[0].features = infinite;
  bad.emplace_back().moved_keyframes = {{KeyFrameId(9), SE3(), KeyFrameId()}};
  bad.emplace_back().moved_keyframes = {{KeyFrameId(1), bad_pose, KeyFrameId()}};
  bad.emplace_back().moved_keyframes = {{KeyFrameId(1), SE3(), KeyFrameId(), 0.0}};
  bad.emplace_back().moved_keyframes = {{KeyFrameId(1), SE3(), KeyFrameId(), NAN}};
  bad.emplace_back().moved_keyframes = {{KeyFrameId(1), SE3(), KeyFrameId(1)}};
  bad.emplace_back().upserted_points = {PointAt(9, {0, nan, 0})};
  bad.emplace_back().upserted_points = {PointAt(0, {0, 0, 0})};
  bad.emplace_back().observations = {{KeyFrameId(9), {}}};
  bad.emplace_back().observations = {{KeyFrameId(1), std::vector<MapPointId>(7)}};
  bad.emplace_back().removed_keyframes = {{KeyFrameId(9), KeyFrameId(1), SE3()}};
  bad.emplace_back().removed_keyframes = {{KeyFrameId(2), KeyFrameId(9), SE3()}};
  bad.emplace_back().removed_keyframes = {{KeyFrameId(2), KeyFrameId(2), SE3()}};
  bad.emplace_back().removed_keyframes = {{KeyFrameId(2), KeyFrameId(), SE3()}};
  bad.emplace_back().frames = {{7, 7, KeyFrameId(9), SE3()}};
  bad.emplace_back().frames = {{7, 7, KeyFrameId(1), bad_pose}};
  for (size_t i = 0; i < bad.size(); ++i) {
    SCOPED_TRACE(i);
    // Good members do not survive beside a bad one.
    bad[i].upserted_points.insert(bad[i].upserted_points.begin(), PointAt(50 + i, {1, 1, 1}));
    ExpectRefused(bad[i]);
  }
}

TEST_P(MapStoreContract, FrameSentAgainReplacesThePose) {
  StartSmallMap();
  MapDelta delta;
  delta.frames.push_back({3, 333, KeyFrameId(3), SE3()});
  ASSERT_TRUE(Apply(delta).ok());
  const std::vector<TrajectoryPose> poses = Trajectory(*store_, map_);
  ASSERT_EQ(poses.size(), 6);
  EXPECT_EQ(poses[3].timestamp, 333);
  EXPECT_EQ(poses[3].reference_keyframe, KeyFrameId(3));
  EXPECT_EQ(store_->GetSession(map_, session_)->stored_frames, 6);
}

TEST_P(MapStoreContract, ObservationsOfAKeyFrameThatNeverHadAny) {
  StartMap();
  MapDelta delta;
  delta.added_keyframes.push_back(KeyFrameWith(1, 5));
  delta.added_keyframes.push_back(KeyFrameWith(2, 0));
  ASSERT_TRUE(Apply(delta).ok());
  EXPECT_EQ(store_->GetObservations(map_, KeyFrameId(1))->point_of_keypoint, std::vector<MapPointId>(5));
  EXPECT_EQ(store_->GetKeyFrame(map_, KeyFrameId(2))->record.features->size(), 0);
  EXPECT_TRUE(absl::IsNotFound(store_->GetObservations(map_, KeyFrameId(3)).status()));
  EXPECT_EQ(Findings(*store_, map_), "");
}

}  // namespace
}  // namespace semmap::storage
