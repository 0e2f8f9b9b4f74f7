// The contract of MapStore: queries, summary, integrity check.
#include <limits>

#include "map_store_contract.h"

namespace semmap::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST_P(MapStoreContract, PointQueriesSelect) {
  StartSmallMap();  // points 1 to 4 at x = 10 to 40, class = id
  MapDelta delta;
  MapPointRecord point = PointAt(5, {25, 1, -1}, 2);
  point.class_confidence = 0.25F;
  point.observation_count = 0;
  point.first_seen = 100;
  point.last_seen = 200;
  delta.upserted_points.push_back(point);
  ASSERT_TRUE(Apply(delta).ok());

  EXPECT_THAT(PointIds(*store_, map_, {.classes = {2, 4}}), ElementsAre(2, 4, 5));
  EXPECT_THAT(PointIds(*store_, map_, {.min_confidence = 0.5F}), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(PointIds(*store_, map_, {.min_observations = 2}), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(PointIds(*store_, map_, {.seen = TimeRange{200, 300}}), ElementsAre(5));
  EXPECT_THAT(PointIds(*store_, map_, {.seen = TimeRange{50, 100}}), IsEmpty());
  EXPECT_THAT(PointIds(*store_, map_, {.seen = TimeRange{0, 101}}), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(PointIds(*store_, map_, {.after = MapPointId(2), .limit = 2}), ElementsAre(3, 4));
  MapPointQuery box;
  // Closed, and exact at its faces.
  box.box = Eigen::AlignedBox3d(Eigen::Vector3d(20, 1, -1), Eigen::Vector3d(30, 1, -1));
  EXPECT_THAT(PointIds(*store_, map_, box), ElementsAre(2, 3, 5));
  box.after = MapPointId(2);
  box.limit = 1;
  EXPECT_THAT(PointIds(*store_, map_, box), ElementsAre(3));
  box = {};
  box.box = Eigen::AlignedBox3d(Eigen::Vector3d(20.001, -9, -9), Eigen::Vector3d(29.999, 9, 9));
  box.classes = {2};
  EXPECT_THAT(PointIds(*store_, map_, box), ElementsAre(5));
  box.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-1e300, -1e300, -1e300), Eigen::Vector3d(1e300, 1e300, 1e300));
  EXPECT_THAT(PointIds(*store_, map_, box), ElementsAre(2, 5));
}

TEST_P(MapStoreContract, PointQueriesStopAndRefuse) {
  StartSmallMap();
  int visited = 0;
  ASSERT_TRUE(store_->ForEachMapPoint(map_, {}, [&](const MapPointRecord&) { return ++visited < 2; }).ok());
  EXPECT_EQ(visited, 2);
  const auto ignore = [](const MapPointRecord&) { return true; };
  MapPointQuery query;
  query.box = Eigen::AlignedBox3d(Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 1));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->ForEachMapPoint(map_, query, ignore)));
  query.box = Eigen::AlignedBox3d(Eigen::Vector3d(0, 0, 0),
                                  Eigen::Vector3d(1, std::numeric_limits<double>::quiet_NaN(), 1));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->ForEachMapPoint(map_, query, ignore)));
  EXPECT_TRUE(absl::IsNotFound(store_->ForEachMapPoint(MapId(9), {}, ignore)));
}

TEST_P(MapStoreContract, GetsPointsByIdInTheOrderAskedFor) {
  StartSmallMap();
  const std::vector<MapPointId> ids = {MapPointId(4), MapPointId(99), MapPointId(1), MapPointId(4)};
  const absl::StatusOr<std::vector<MapPointRecord>> points = store_->GetMapPoints(map_, ids);
  ASSERT_TRUE(points.ok());
  ASSERT_EQ(points->size(), 3);
  EXPECT_TRUE(SamePoint(points->at(0), SmallDelta().upserted_points[3]));
  EXPECT_EQ(points->at(1).id, MapPointId(1));
  EXPECT_EQ(points->at(2).id, MapPointId(4));
}

TEST_P(MapStoreContract, PointsFarOutAreFound) {
  StartMap();
  MapDelta delta;
  delta.added_keyframes.push_back(KeyFrameWith(1, 0));
  delta.upserted_points.push_back(PointAt(1, {1e12, -1e12, 1e300}));
  delta.upserted_points.push_back(PointAt(2, {-0.125, -0.125, -0.125}));
  for (MapPointRecord& point : delta.upserted_points) point.observation_count = 0;
  ASSERT_TRUE(Apply(delta).ok());
  MapPointQuery query;
  query.box = Eigen::AlignedBox3d(Eigen::Vector3d(1e11, -1e13, 0), Eigen::Vector3d(1e13, 0, 1e301));
  EXPECT_THAT(PointIds(*store_, map_, query), ElementsAre(1));
  query.box = Eigen::AlignedBox3d(Eigen::Vector3d(-0.13, -0.13, -0.13), Eigen::Vector3d(0, 0, 0));
  EXPECT_THAT(PointIds(*store_, map_, query), ElementsAre(2));
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(MapStoreContract, KeyFrameQueriesSelect) {
  StartSmallMap();  // at x = id, time = 1000 * id
  EXPECT_EQ(AllKeyFrames(*store_, map_)[0].record.features, nullptr);
  EXPECT_THAT(KeyFrameIds(*store_, map_, {.time = TimeRange{2000, 3000}}), ElementsAre(2));
  EXPECT_THAT(KeyFrameIds(*store_, map_, {.time = TimeRange{}}), ElementsAre(1, 2, 3));
  EXPECT_THAT(KeyFrameIds(*store_, map_, {.session = SessionId(99)}), IsEmpty());
  EXPECT_THAT(KeyFrameIds(*store_, map_, {.after = KeyFrameId(1), .limit = 1}), ElementsAre(2));
  KeyFrameQuery box;
  box.box = Eigen::AlignedBox3d(Eigen::Vector3d(1.5, -1, -1), Eigen::Vector3d(3, 1, 1));
  EXPECT_THAT(KeyFrameIds(*store_, map_, box), ElementsAre(2, 3));
  box.time = TimeRange{3000, 3001};
  EXPECT_THAT(KeyFrameIds(*store_, map_, box), ElementsAre(3));
  box.time.reset();
  box.after = KeyFrameId(2);
  EXPECT_THAT(KeyFrameIds(*store_, map_, box), ElementsAre(3));
}

TEST_P(MapStoreContract, TrajectoryIsComposedInOrder) {
  StartSmallMap();
  const std::vector<TrajectoryPose> poses = Trajectory(*store_, map_);
  ASSERT_EQ(poses.size(), 6);
  const MapDelta delta = SmallDelta();
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(poses[i].sequence, i);
    EXPECT_EQ(poses[i].session, session_);
    const SE3 expected = delta.added_keyframes[i / 2].map_from_camera * delta.frames[i].keyframe_from_camera;
    EXPECT_TRUE(SamePose(poses[i].map_from_camera, expected)) << i;
  }
}

TEST_P(MapStoreContract, TrajectoryQueriesSelect) {
  StartSmallMap();
  const absl::StatusOr<SessionInfo> other = store_->StartSession(SessionOf(map_, "other"));
  MapDelta delta;
  delta.version = 1;
  delta.frames = {{2, 900, KeyFrameId(1), SE3()}, {1, 800, KeyFrameId(1), SE3()}};
  ASSERT_TRUE(store_->Apply(map_, other->id, delta).ok());
  const auto sequences = [&](const TrajectoryQuery& query) {
    std::vector<uint64_t> result;
    for (const TrajectoryPose& pose : Trajectory(*store_, map_, query)) result.push_back(pose.sequence);
    return result;
  };
  EXPECT_THAT(sequences({}), ElementsAre(0, 1, 2, 3, 4, 5, 1, 2));
  EXPECT_THAT(sequences({.session = other->id}), ElementsAre(1, 2));
  EXPECT_THAT(sequences({.time = TimeRange{400, 900}}), ElementsAre(4, 5, 1));
  EXPECT_THAT(sequences({.after = TrajectoryQuery::Position{session_, 4}, .limit = 2}), ElementsAre(5, 1));
  EXPECT_THAT(sequences({.session = session_, .after = TrajectoryQuery::Position{session_, 4}}),
              ElementsAre(5));
  EXPECT_THAT(sequences({.limit = 1}), ElementsAre(0));
  int visited = 0;
  ASSERT_TRUE(
      store_->ForEachTrajectoryPose(map_, {}, [&](const TrajectoryPose&) { return ++visited < 3; }).ok());
  EXPECT_EQ(visited, 3);
}

TEST_P(MapStoreContract, SummaryAddsUp) {
  StartSmallMap();
  const absl::StatusOr<MapSummary> summary = store_->Summarize(map_);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->map.name, "town");
  EXPECT_EQ(summary->camera_extent.max(), Eigen::Vector3d(3, 0, 0));
  EXPECT_EQ(summary->point_extent.min(), Eigen::Vector3d(10, 1, -1));
  EXPECT_EQ(summary->point_extent.max(), Eigen::Vector3d(40, 1, -1));
  ASSERT_EQ(summary->points_per_class.size(), 4);
  EXPECT_EQ(summary->points_per_class[2].semantic_class, 3);
  EXPECT_EQ(summary->points_per_class[2].points, 1);
  EXPECT_EQ(summary->session_count, 1);
  EXPECT_EQ(summary->frame_count, 6);
  const std::vector<TrajectoryPose> poses = Trajectory(*store_, map_);
  double length = 0;
  for (size_t i = 1; i < poses.size(); ++i) {
    length += (poses[i].map_from_camera.translation() - poses[i - 1].map_from_camera.translation()).norm();
  }
  EXPECT_DOUBLE_EQ(summary->trajectory_length, length);
  EXPECT_EQ(summary->first_keyframe_time, 1000);
  EXPECT_EQ(summary->last_keyframe_time, 3000);
  EXPECT_GT(summary->feature_bytes, 3 * 8 * 32);
  EXPECT_GT(summary->observation_bytes, 0);
  EXPECT_GT(summary->database_bytes, summary->feature_bytes);
  EXPECT_EQ(*store_->DatabaseBytes(), summary->database_bytes);
  EXPECT_TRUE(absl::IsNotFound(store_->Summarize(MapId(9)).status()));
}

TEST_P(MapStoreContract, SummaryOfAnEmptyMap) {
  StartMap();
  const absl::StatusOr<MapSummary> summary = store_->Summarize(map_);
  ASSERT_TRUE(summary.ok());
  EXPECT_TRUE(summary->camera_extent.isEmpty());
  EXPECT_TRUE(summary->point_extent.isEmpty());
  EXPECT_TRUE(summary->points_per_class.empty());
  EXPECT_EQ(summary->trajectory_length, 0);
}

// --- Integrity: what Apply cannot see for itself is found

TEST_P(MapStoreContract, IntegrityCheckFindsContradictions) {
  StartSmallMap();
  MapDelta delta;
  delta.added_keyframes = {KeyFrameWith(4, 3), KeyFrameWith(5, 0), KeyFrameWith(6, 0)};
  delta.added_keyframes[0].parent = KeyFrameId(40);
  delta.added_keyframes[1].parent = KeyFrameId(6);
  delta.added_keyframes[2].parent = KeyFrameId(5);
  delta.observations = {{KeyFrameId(4), {MapPointId(1), MapPointId(1), MapPointId(99)}}};
  delta.upserted_points = {PointAt(5, {0, 0, 0})};
  delta.upserted_points[0].reference_keyframe = KeyFrameId(41);
  ASSERT_TRUE(Apply(delta).ok());
  const std::string findings = Findings(*store_, map_);
  for (const char* kind : {"dangling-parent", "cycle", "duplicate-observation", "dangling-observation",
                           "dangling-reference", "count-mismatch"}) {
    EXPECT_THAT(findings, testing::HasSubstr(kind));
  }
  EXPECT_EQ(store_->CheckIntegrity(map_, 2)->size(), 2);
  EXPECT_TRUE(absl::IsNotFound(store_->CheckIntegrity(MapId(9), 1).status()));
}

}  // namespace
}  // namespace semmap::storage
