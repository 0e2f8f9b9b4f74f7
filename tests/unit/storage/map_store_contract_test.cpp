// What every backend must do, whatever lies under it. A backend joins by a line in INSTANTIATE_TEST_SUITE_P.
#include <cmath>
#include <functional>
#include <limits>

#include "storage_test_support.h"

namespace semmap::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Backend {
  std::string name;
  // The configuration of a store in this directory; the same one again opens the same store.
  std::function<StorageConfig(const TempDir&)> config;
};

class MapStoreContract : public testing::TestWithParam<Backend> {
 protected:
  MapStoreContract() : config_(GetParam().config(dir_)), store_(OpenOrDie(config_)) {}

  void Reopen() {
    store_.reset();
    store_ = OpenOrDie(config_);
  }

  // A map with one session, whose deltas Apply numbers.
  void StartMap(const std::string& name = "town") {
    const absl::StatusOr<MapInfo> map = store_->CreateMap(MapNamed(name));
    ASSERT_TRUE(map.ok()) << map.status();
    map_ = map->id;
    const absl::StatusOr<SessionInfo> session = store_->StartSession(SessionOf(map_, "session-of-" + name));
    ASSERT_TRUE(session.ok()) << session.status();
    session_ = session->id;
    version_ = 0;
  }

  absl::Status Apply(MapDelta delta) {
    delta.version = version_ + 1;
    const absl::Status status = store_->Apply(map_, session_, delta);
    if (status.ok()) ++version_;
    return status;
  }

  // Keyframes 1 to 3 (2 and 3 children of 1) with 8 keypoints each, points 1 to 4, frames 0 to 5.
  MapDelta SmallDelta() {
    MapDelta delta;
    for (uint64_t id = 1; id <= 3; ++id) {
      delta.added_keyframes.push_back(KeyFrameWith(id, 8, {static_cast<double>(id), 0, 0}));
      if (id > 1) delta.added_keyframes.back().parent = KeyFrameId(1);
      delta.observations.push_back({KeyFrameId(id), std::vector<MapPointId>(8)});
    }
    for (uint64_t id = 1; id <= 4; ++id) {
      delta.upserted_points.push_back(
          PointAt(id, {10.0 * static_cast<double>(id), 1, -1}, static_cast<uint8_t>(id)));
      for (size_t k = 0; k < 2; ++k) delta.observations[k].point_of_keypoint[id] = MapPointId(id);
      delta.upserted_points.back().observation_count = 2;
    }
    for (uint64_t sequence = 0; sequence <= 5; ++sequence) {
      const KeyFrameId reference(1 + sequence / 2);
      delta.frames.push_back({sequence, static_cast<TimestampNs>(100 * sequence), reference,
                              SE3(Eigen::Quaterniond(1, 0.1, 0, 0), {0, static_cast<double>(sequence), 0})});
    }
    return delta;
  }

  void StartSmallMap() {
    StartMap();
    const absl::Status status = Apply(SmallDelta());
    ASSERT_TRUE(status.ok()) << status;
  }

  void ExpectRefused(const MapDelta& delta, absl::StatusCode code = absl::StatusCode::kInvalidArgument) {
    const absl::StatusOr<MapInfo> before = store_->GetMap(map_);
    const absl::Status status = Apply(delta);
    EXPECT_EQ(status.code(), code) << status;
    const absl::StatusOr<MapInfo> after = store_->GetMap(map_);
    EXPECT_EQ(before->version, after->version);
    EXPECT_EQ(before->keyframe_count, after->keyframe_count);
    EXPECT_EQ(before->point_count, after->point_count);
    EXPECT_EQ(Findings(*store_, map_), "");
  }

  TempDir dir_;
  StorageConfig config_;
  std::unique_ptr<MapStore> store_;
  MapId map_;
  SessionId session_;
  uint64_t version_ = 0;
};

// --- Maps

TEST_P(MapStoreContract, CreatesAndGetsMaps) {
  NewMap wanted = MapNamed("A-1.b_c");
  wanted.scale_known = false;
  const absl::StatusOr<MapInfo> created = store_->CreateMap(wanted);
  ASSERT_TRUE(created.ok()) << created.status();
  EXPECT_TRUE(created->id.IsValid());
  Reopen();
  for (const absl::StatusOr<MapInfo>& map : {store_->GetMap("A-1.b_c"), store_->GetMap(created->id)}) {
    ASSERT_TRUE(map.ok()) << map.status();
    EXPECT_EQ(map->id, created->id);
    EXPECT_EQ(map->name, "A-1.b_c");
    EXPECT_EQ(map->created_at, wanted.created_at);
    EXPECT_FALSE(map->scale_known);
    EXPECT_FALSE(map->anchor.has_value());
    EXPECT_EQ(map->rig.sensor, SensorType::kStereo);
    EXPECT_EQ(map->rig.baseline_m, 0.537);
    EXPECT_TRUE(SamePose(map->rig.body_from_camera, wanted.rig.body_from_camera));
    EXPECT_EQ(map->keyframe_count + map->point_count + map->version, 0);
    EXPECT_TRUE(map->camera_extent.isEmpty());
  }
}

TEST_P(MapStoreContract, RefusesBadMaps) {
  for (const std::string& name :
       {std::string(), std::string("."), std::string("-a"), std::string("_a"), std::string("a b"),
        std::string("a/b"), std::string("\xC3\xA4"), std::string("a\0b", 3), std::string(64, 'a')}) {
    EXPECT_TRUE(absl::IsInvalidArgument(store_->CreateMap(MapNamed(name)).status())) << name;
  }
  EXPECT_TRUE(store_->CreateMap(MapNamed(std::string(63, 'a'))).ok());
  NewMap map = MapNamed("a");
  map.rig.camera.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(absl::IsInvalidArgument(store_->CreateMap(map).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->GetMap("a").status()));
}

TEST_P(MapStoreContract, NamesAreUniqueAndIdsAreNotUsedAgain) {
  const absl::StatusOr<MapInfo> first = store_->CreateMap(MapNamed("a"));
  ASSERT_TRUE(first.ok());
  EXPECT_TRUE(absl::IsAlreadyExists(store_->CreateMap(MapNamed("a")).status()));
  ASSERT_TRUE(store_->DeleteMap(first->id).ok());
  const absl::StatusOr<MapInfo> second = store_->CreateMap(MapNamed("a"));
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_NE(first->id, second->id);
}

TEST_P(MapStoreContract, ListsMapsInPages) {
  for (const char* name : {"b", "a", "d", "c", "B"}) ASSERT_TRUE(store_->CreateMap(MapNamed(name)).ok());
  const auto names = [&](const MapListQuery& query) {
    std::vector<std::string> result;
    const absl::StatusOr<std::vector<MapInfo>> maps = store_->ListMaps(query);
    EXPECT_TRUE(maps.ok()) << maps.status();
    for (const MapInfo& map : *maps) result.push_back(map.name);
    return result;
  };
  EXPECT_THAT(names({}), ElementsAre("B", "a", "b", "c", "d"));
  EXPECT_THAT(names({"", 2}), ElementsAre("B", "a"));
  EXPECT_THAT(names({"a", 2}), ElementsAre("b", "c"));
  EXPECT_THAT(names({"c", 2}), ElementsAre("d"));
  EXPECT_THAT(names({"d", 2}), IsEmpty());
}

TEST_P(MapStoreContract, AnchorsComeAndGo) {
  StartMap();
  GeoAnchor anchor{59.93, 30.31, 12.5, {2.0, SE3(Eigen::Quaterniond(0, 0, 0.6, 0.8), {1, 2, -0.0})}};
  ASSERT_TRUE(store_->SetAnchor(map_, anchor).ok());
  Reopen();
  absl::StatusOr<MapInfo> map = store_->GetMap(map_);
  ASSERT_TRUE(map.ok() && map->anchor.has_value());
  EXPECT_EQ(map->anchor->latitude_deg, 59.93);
  EXPECT_EQ(map->anchor->longitude_deg, 30.31);
  EXPECT_EQ(map->anchor->altitude_m, 12.5);
  EXPECT_EQ(map->anchor->enu_from_map.scale, 2.0);
  EXPECT_TRUE(SamePose(map->anchor->enu_from_map.rigid, anchor.enu_from_map.rigid));
  ASSERT_TRUE(store_->SetAnchor(map_, std::nullopt).ok());
  EXPECT_FALSE(store_->GetMap(map_)->anchor.has_value());
  anchor.latitude_deg = 90.1;
  EXPECT_TRUE(absl::IsInvalidArgument(store_->SetAnchor(map_, anchor)));
  anchor.latitude_deg = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(absl::IsInvalidArgument(store_->SetAnchor(map_, anchor)));
  EXPECT_TRUE(absl::IsNotFound(store_->SetAnchor(MapId(99), std::nullopt)));
}

TEST_P(MapStoreContract, DeletingTakesEverythingAndNothingElse) {
  StartSmallMap();
  const MapId kept = map_;
  const SessionId kept_session = session_;
  StartMap("other");
  ASSERT_TRUE(Apply(SmallDelta()).ok());
  ASSERT_TRUE(store_->DeleteMap(map_).ok());
  EXPECT_TRUE(absl::IsNotFound(store_->GetMap("other").status()));
  EXPECT_TRUE(absl::IsNotFound(store_->GetSession("session-of-other").status()));
  EXPECT_TRUE(absl::IsNotFound(store_->GetSession(map_, session_).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->GetKeyFrame(map_, KeyFrameId(1)).status()));
  EXPECT_TRUE(
      absl::IsNotFound(store_->ForEachMapPoint(map_, {}, [](const MapPointRecord&) { return true; })));
  EXPECT_TRUE(absl::IsNotFound(store_->DeleteMap(map_)));
  EXPECT_TRUE(absl::IsNotFound(Apply(MapDelta())));
  EXPECT_EQ(store_->ListMaps({})->size(), 1);
  EXPECT_EQ(Findings(*store_, kept), "");
  EXPECT_THAT(PointIds(*store_, kept), ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(Trajectory(*store_, kept).size(), 6);
  // The session's name is free again.
  EXPECT_TRUE(store_->StartSession(SessionOf(kept, "session-of-other")).ok());
  EXPECT_TRUE(store_->GetSession(kept, kept_session).ok());
}

TEST_P(MapStoreContract, MapsDoNotSeeEachOther) {
  StartSmallMap();
  const MapId first = map_;
  const SessionId first_session = session_;
  StartMap("other");
  MapDelta delta;
  delta.added_keyframes.push_back(KeyFrameWith(1, 3, {1, 0, 0}));
  delta.upserted_points.push_back(PointAt(2, {20, 1, -1}));
  delta.frames.push_back({77, 1, KeyFrameId(1), SE3()});
  ASSERT_TRUE(Apply(delta).ok());
  MapPointQuery near;
  near.box = Eigen::AlignedBox3d(Eigen::Vector3d(19, 0, -2), Eigen::Vector3d(21, 2, 2));
  EXPECT_EQ(AllPoints(*store_, map_, near).at(0).semantic_class, 7);
  EXPECT_EQ(AllPoints(*store_, first, near).at(0).semantic_class, 2);
  EXPECT_EQ(store_->GetKeyFrame(map_, KeyFrameId(1))->keypoint_count, 3);
  EXPECT_EQ(store_->GetKeyFrame(first, KeyFrameId(1))->keypoint_count, 8);
  EXPECT_EQ(Trajectory(*store_, map_).size(), 1);
  // A session belongs to one map only.
  EXPECT_TRUE(absl::IsNotFound(store_->GetSession(map_, SessionId(99)).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->Apply(map_, SessionId(99), delta)));
  MapDelta reset;
  reset.reset = true;
  ASSERT_TRUE(Apply(reset).ok());
  EXPECT_EQ(store_->GetMap(map_)->keyframe_count, 0);
  EXPECT_EQ(store_->GetMap(first)->keyframe_count, 3);
  EXPECT_EQ(store_->GetSession(first, first_session)->stored_frames, 6);
}

// --- Sessions

TEST_P(MapStoreContract, SessionsLiveAndEnd) {
  StartMap();
  absl::StatusOr<SessionInfo> session = store_->GetSession("session-of-town");
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->id, session_);
  EXPECT_EQ(session->map, map_);
  EXPECT_EQ(session->vehicle_id, "vehicle-7");
  EXPECT_EQ(session->started_at, 1700000000000000001);
  EXPECT_EQ(session->rig.camera.fx, 718.856);
  EXPECT_FALSE(session->ended_at.has_value());
  EXPECT_FALSE(session->last_durable_sequence.has_value());
  EXPECT_EQ(session->last_delta_version, 0);

  ASSERT_TRUE(store_->UpdateSession(map_, session_, {10, 9}).ok());
  EXPECT_EQ(store_->GetSession(map_, session_)->counters.frames_tracked, 9);
  ASSERT_TRUE(store_->EndSession(map_, session_, 1700000000000000009, {20, 18}).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(store_->EndSession(map_, session_, 1, {})));
  EXPECT_TRUE(absl::IsFailedPrecondition(Apply(SmallDelta())));
  Reopen();
  session = store_->GetSession(map_, session_);
  ASSERT_TRUE(session.ok());
  EXPECT_EQ(session->ended_at, 1700000000000000009);
  EXPECT_EQ(session->counters.frames_received, 20);
  EXPECT_EQ(session->counters.frames_tracked, 18);
}

TEST_P(MapStoreContract, RefusesBadSessions) {
  StartMap();
  EXPECT_TRUE(absl::IsAlreadyExists(store_->StartSession(SessionOf(map_, "session-of-town")).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->StartSession(SessionOf(MapId(9), "x")).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->StartSession(SessionOf(map_, "")).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->StartSession(SessionOf(map_, "a b")).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->StartSession(SessionOf(map_, std::string(129, 'a'))).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->UpdateSession(map_, SessionId(5), {})));
  EXPECT_TRUE(absl::IsNotFound(store_->EndSession(map_, SessionId(5), 1, {})));
  EXPECT_TRUE(absl::IsNotFound(store_->GetSession("nobody").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->UpdateSession(map_, session_, {~uint64_t{0}, 0})));
}

TEST_P(MapStoreContract, ListsSessionsInPages) {
  StartMap();
  ASSERT_TRUE(store_->StartSession(SessionOf(map_, "s2")).ok());
  ASSERT_TRUE(store_->StartSession(SessionOf(map_, "s3")).ok());
  const absl::StatusOr<std::vector<SessionInfo>> all = store_->ListSessions(map_, SessionId(), 0);
  ASSERT_TRUE(all.ok());
  ASSERT_EQ(all->size(), 3);
  const absl::StatusOr<std::vector<SessionInfo>> page = store_->ListSessions(map_, all->at(0).id, 1);
  ASSERT_EQ(page->size(), 1);
  EXPECT_EQ(page->at(0).name, "s2");
  EXPECT_TRUE(absl::IsNotFound(store_->ListSessions(MapId(9), SessionId(), 0).status()));
}

// --- Deltas

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

// --- Queries

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

INSTANTIATE_TEST_SUITE_P(Backends, MapStoreContract,
                         testing::Values(Backend{"SqliteNormal",
                                                 [](const TempDir& dir) {
                                                   return ConfigFor(dir.File("maps.db"));
                                                 }},
                                         Backend{"SqliteFull",
                                                 [](const TempDir& dir) {
                                                   StorageConfig config =
                                                       ConfigFor(dir.File("\xC3\xBC maps?.db"));
                                                   config.synchronous = "full";
                                                   config.max_readers = 1;
                                                   return config;
                                                 }}),
                         [](const testing::TestParamInfo<Backend>& backend) { return backend.param.name; });

}  // namespace
}  // namespace semmap::storage
