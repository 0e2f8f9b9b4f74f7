#include <algorithm>

#include "map_store_contract.h"
#include "storage/joined_map_loader.h"
#include "storage/map_loader.h"
#include "tests/support/ring_world.h"

// Maps that are made over as a whole: joined with another one, changed, thinned out.
namespace semmap::storage {
namespace {

using semmap::testing::DriveRing;
using semmap::testing::RingWorld;

constexpr size_t kEnough = size_t{1} << 30;
constexpr double kStep = 0.13;
constexpr int kKeyFrames = 8;

class RewriteContract : public MapStoreContract {
 protected:
  struct Stored {
    MapInfo map;
    SessionId session;
  };

  // The map of a drive with a frame beside each keyframe.
  Stored StoreDrive(const std::string& name, SensorType sensor, int first) {
    const MappingCamera camera = RingWorld::Camera(sensor);
    NewMap new_map = MapNamed(name);
    new_map.rig = camera.rig;
    new_map.scale_known = sensor != SensorType::kMono;
    const MapId id = store_->CreateMap(new_map)->id;
    NewSession session = SessionOf(id, "drive-" + name);
    session.rig = camera.rig;
    const SessionId session_id = store_->StartSession(session)->id;
    Map map = DriveRing(RingWorld(1), camera, kKeyFrames, kStep, {}, first);
    MapDelta delta = map.TakeDelta();
    delta.version = 1;
    for (const KeyFrameRecord& keyframe : delta.added_keyframes) {
      delta.frames.push_back({10 * keyframe.id.value(), keyframe.timestamp + 5, keyframe.id,
                              SE3(Eigen::Quaterniond::Identity(), {0, 0, 0.5})});
    }
    EXPECT_TRUE(store_->Apply(id, session_id, delta).ok());
    return {*store_->GetMap(id), session_id};
  }

  JoinedMaps LoadBoth(bool forget_depth = false) {
    auto maps = LoadJoinedMaps(*store_, target_.map.id, source_.map.id, RingWorld::ScaleInfo(), kEnough, {},
                               forget_depth);
    EXPECT_TRUE(maps.ok()) << maps.status();
    return *std::move(maps);
  }

  // Moves all of the source by a similarity.
  static void MoveSource(const Sim3& target_from_source, KeyFrameId last_of_target, Map* map) {
    std::vector<KeyFrameId> keyframes;
    for (const auto& [id, keyframe] : map->keyframes()) {
      if (id > last_of_target) keyframes.push_back(id);
    }
    for (const KeyFrameId id : keyframes) {
      const SE3 pose = map->FindKeyFrame(id)->camera_from_map.Inverse();
      map->SetPose(id, SE3(target_from_source.rigid.rotation() * pose.rotation(),
                           target_from_source * pose.translation())
                           .Inverse());
      if (target_from_source.scale != 1) map->NoteRescaled(id, target_from_source.scale);
    }
    std::vector<MapPointId> points;
    for (const auto& [id, point] : map->points()) {
      if (point.reference_keyframe > last_of_target) points.push_back(id);
    }
    for (const MapPointId id : points)
      map->SetPosition(id, target_from_source * map->FindPoint(id)->position_in_map);
  }

  MapRewrite RewriteOf(const JoinedMaps& maps, MapDelta changes) const {
    MapRewrite rewrite;
    rewrite.map = {maps.target.id, maps.target.version};
    rewrite.joined = MapRewrite::Basis{maps.source.id, maps.source.version};
    rewrite.changes = std::move(changes);
    return rewrite;
  }

  // What is stored equals what is in memory.
  void ExpectStored(MapId id, const Map& map) {
    EXPECT_EQ(Findings(*store_, id), "");
    const auto loaded = LoadMap(*store_, id, RingWorld::ScaleInfo(), kEnough);
    ASSERT_TRUE(loaded.ok()) << loaded.status();
    ASSERT_EQ(loaded->map.keyframes().size(), map.keyframes().size());
    for (const auto& [keyframe_id, expected] : map.keyframes()) {
      const KeyFrame* keyframe = loaded->map.FindKeyFrame(keyframe_id);
      ASSERT_NE(keyframe, nullptr) << keyframe_id.value();
      EXPECT_LT((keyframe->Center() - expected.Center()).norm(), 1e-9);
      EXPECT_EQ(keyframe->parent, expected.parent);
      EXPECT_EQ(keyframe->points, expected.points);
      EXPECT_TRUE(SameFeatures(*keyframe->features, *expected.features));
    }
    ASSERT_EQ(loaded->map.points().size(), map.points().size());
    for (const auto& [point_id, expected] : map.points()) {
      const MapPoint* point = loaded->map.FindPoint(point_id);
      ASSERT_NE(point, nullptr) << point_id.value();
      EXPECT_EQ(point->position_in_map, expected.position_in_map);
      EXPECT_EQ(point->reference_keyframe, expected.reference_keyframe);
      EXPECT_EQ(point->observations.size(), expected.observations.size());
    }
  }

  std::vector<std::string> MapNames() {
    std::vector<std::string> names;
    const std::vector<MapInfo> maps = *store_->ListMaps({});
    for (const MapInfo& map : maps) names.push_back(map.name);
    return names;
  }

  void StoreBoth(SensorType target, SensorType source) {
    target_ = StoreDrive("target", target, 0);
    source_ = StoreDrive("source", source, 5);
  }

  Stored target_;
  Stored source_;
  const Sim3 moved_{2.0, SE3(ExpSO3({0, 0.3, 0}), {5, 0, 1})};
};

TEST_P(RewriteContract, AMapIsJoinedWithAllThatBelongsToIt) {
  StoreBoth(SensorType::kStereo, SensorType::kStereo);
  JoinedMaps maps = LoadBoth();
  EXPECT_EQ(maps.map.keyframes().size(), 2U * kKeyFrames);
  MoveSource(moved_, maps.target.last_keyframe_id, &maps.map);
  maps.map.GraftTree(KeyFrameId(kKeyFrames + 3), KeyFrameId(6));
  // Two points become one, across the seam.
  const MapPointId kept = maps.map.FindKeyFrame(KeyFrameId(2))->points[0];
  const MapPointId dropped = maps.map.FindKeyFrame(KeyFrameId(kKeyFrames + 2))->points[0];
  maps.map.MergePoints(kept, dropped);
  const auto rewritten = store_->RewriteMap(RewriteOf(maps, maps.map.TakeDelta()), nullptr);
  ASSERT_TRUE(rewritten.ok()) << rewritten.status();
  EXPECT_EQ(rewritten->name, "target");
  EXPECT_NE(rewritten->id, target_.map.id);
  EXPECT_EQ(rewritten->version, target_.map.version + 1);
  EXPECT_EQ(rewritten->created_at, target_.map.created_at);
  EXPECT_EQ(MapNames(), (std::vector<std::string>{"source", "target"}));
  Reopen();
  ExpectStored(rewritten->id, maps.map);
  // Sessions: the target's keep their names, the source's are still the source's.
  const auto sessions = *store_->ListSessions(rewritten->id, SessionId(), 0);
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_EQ(sessions[0].name, "drive-target");
  EXPECT_EQ(sessions[1].name, "drive-source-" + std::to_string(rewritten->id.value()));
  EXPECT_EQ(store_->GetSession("drive-source")->map, source_.map.id);
  // Frames came along with their keyframes, and are as far from them as the new unit says.
  const auto frames = Trajectory(*store_, rewritten->id, {.session = sessions[1].id});
  ASSERT_EQ(frames.size(), static_cast<size_t>(kKeyFrames));
  for (const TrajectoryPose& frame : frames) {
    const KeyFrame& keyframe = *maps.map.FindKeyFrame(frame.reference_keyframe);
    EXPECT_NEAR((frame.map_from_camera.translation() - keyframe.Center()).norm(), 2 * 0.5, 1e-9);
  }
  EXPECT_EQ(Findings(*store_, source_.map.id), "") << "which is as it was";
}

TEST_P(RewriteContract, TheJoinedMapCanGo) {
  StoreBoth(SensorType::kStereo, SensorType::kStereo);
  JoinedMaps maps = LoadBoth();
  MoveSource({}, maps.target.last_keyframe_id, &maps.map);
  MapRewrite rewrite = RewriteOf(maps, maps.map.TakeDelta());
  rewrite.delete_joined = true;
  const auto rewritten = store_->RewriteMap(rewrite, nullptr);
  ASSERT_TRUE(rewritten.ok()) << rewritten.status();
  EXPECT_EQ(MapNames(), (std::vector<std::string>{"target"}));
  EXPECT_EQ(store_->GetSession("drive-source")->map, rewritten->id);
  ExpectStored(rewritten->id, maps.map);
  // It grows on behind what it held.
  const auto session = store_->StartSession(SessionOf(rewritten->id, "later"));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->id, SessionId(3));
  EXPECT_EQ(rewritten->last_keyframe_id, KeyFrameId(2 * kKeyFrames));
}

TEST_P(RewriteContract, OneEyeForgetsDepth) {
  StoreBoth(SensorType::kMono, SensorType::kStereo);
  JoinedMaps maps = LoadBoth(true);
  MoveSource(moved_, maps.target.last_keyframe_id, &maps.map);
  const auto rewritten = store_->RewriteMap(RewriteOf(maps, maps.map.TakeDelta()), nullptr);
  ASSERT_TRUE(rewritten.ok()) << rewritten.status();
  EXPECT_FALSE(rewritten->scale_known);
  ExpectStored(rewritten->id, maps.map);
  for (const KeyFrameEntry& keyframe : AllKeyFrames(*store_, rewritten->id, {.with_features = true})) {
    for (const Keypoint& keypoint : keyframe.record.features->keypoints) {
      EXPECT_FALSE(keypoint.HasDepth());
      EXPECT_LT(keypoint.right_x, 0);
    }
  }
}

TEST_P(RewriteContract, KeyframesAndPointsGo) {
  StoreBoth(SensorType::kStereo, SensorType::kStereo);
  auto loaded = LoadMap(*store_, target_.map.id, RingWorld::ScaleInfo(), kEnough);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  const auto before = Trajectory(*store_, target_.map.id);
  Map& map = loaded->map;
  map.RemoveKeyFrame(KeyFrameId(5));
  map.RemoveKeyFrame(KeyFrameId(4));
  map.RemovePoint(map.FindKeyFrame(KeyFrameId(3))->points[7]);
  MapRewrite rewrite;
  rewrite.map = {target_.map.id, target_.map.version};
  rewrite.changes = map.TakeDelta();
  const auto rewritten = store_->RewriteMap(rewrite, nullptr);
  ASSERT_TRUE(rewritten.ok()) << rewritten.status();
  EXPECT_EQ(rewritten->keyframe_count, static_cast<uint64_t>(kKeyFrames - 2));
  EXPECT_EQ(rewritten->point_count, map.points().size());
  ExpectStored(rewritten->id, map);
  // The frames of what went hang on heirs, and are where they were.
  const auto after = Trajectory(*store_, rewritten->id);
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) {
    EXPECT_LT((after[i].map_from_camera.translation() - before[i].map_from_camera.translation()).norm(),
              1e-9);
  }
}

TEST_P(RewriteContract, WhatIsSaidOfAMapStaysAsItIsByThen) {
  StoreBoth(SensorType::kStereo, SensorType::kStereo);
  auto loaded = LoadMap(*store_, target_.map.id, RingWorld::ScaleInfo(), kEnough);
  MapRewrite rewrite;
  rewrite.map = {target_.map.id, target_.map.version};
  loaded->map.SetPosition(loaded->map.points().begin()->first, {1, 2, 3});
  rewrite.changes = loaded->map.TakeDelta();
  rewrite.anchor = GeoAnchor{48, 11, 500, {}, GeoAnchor::Source::kFitted, 1.5};
  const auto describe_meanwhile = [&](double) {
    EXPECT_TRUE(store_->UpdateMap(target_.map.id, {.display_name = "Old town"}).ok());
    return true;
  };
  const auto rewritten = store_->RewriteMap(rewrite, describe_meanwhile);
  ASSERT_TRUE(rewritten.ok()) << rewritten.status();
  EXPECT_EQ(rewritten->display_name, "Old town");
  ASSERT_TRUE(rewritten->anchor.has_value());
  EXPECT_EQ(rewritten->anchor->latitude_deg, 48);
  // A map that has an anchor keeps it.
  rewrite.map = {rewritten->id, rewritten->version};
  rewrite.anchor->latitude_deg = 10;
  const auto again = store_->RewriteMap(rewrite, nullptr);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->anchor->latitude_deg, 48);
}

TEST_P(RewriteContract, WhatFailsLeavesEverythingAsItWas) {
  StoreBoth(SensorType::kStereo, SensorType::kStereo);
  JoinedMaps maps = LoadBoth();
  MoveSource({}, maps.target.last_keyframe_id, &maps.map);
  const MapDelta changes = maps.map.TakeDelta();
  const auto expect_failure = [&](const MapRewrite& rewrite, const ProgressVisitor& progress,
                                  absl::StatusCode code) {
    const absl::Status status = store_->RewriteMap(rewrite, progress).status();
    EXPECT_EQ(status.code(), code) << status;
    EXPECT_EQ(MapNames(), (std::vector<std::string>{"source", "target"}));
    EXPECT_EQ(store_->GetMap("target")->id, target_.map.id);
    EXPECT_EQ(Findings(*store_, target_.map.id), "");
    EXPECT_EQ(store_->GetSession("drive-target")->map, target_.map.id);
  };
  MapRewrite rewrite = RewriteOf(maps, changes);
  int visits = 0;
  expect_failure(
      rewrite, [&](double) { return ++visits < 4; }, absl::StatusCode::kCancelled);
  rewrite.map.version += 1;
  expect_failure(rewrite, nullptr, absl::StatusCode::kAborted);
  rewrite = RewriteOf(maps, changes);
  rewrite.joined->map = MapId(99);
  expect_failure(rewrite, nullptr, absl::StatusCode::kAborted);
  // Points of the joined map that nobody moved are in no cell.
  rewrite = RewriteOf(maps, {});
  expect_failure(rewrite, nullptr, absl::StatusCode::kInvalidArgument);
  rewrite = RewriteOf(maps, changes);
  rewrite.changes.frames.push_back({1, 1, KeyFrameId(1), SE3()});
  expect_failure(rewrite, nullptr, absl::StatusCode::kInvalidArgument);
  rewrite = RewriteOf(maps, changes);
  rewrite.changes.upserted_points.push_back(PointAt(5'000'000, {1, 2, 3}));
  expect_failure(rewrite, nullptr, absl::StatusCode::kInvalidArgument);
  // A vehicle adds to the target while it is made over.
  rewrite = RewriteOf(maps, changes);
  bool changed = false;
  const auto change_meanwhile = [&](double) {
    if (std::exchange(changed, true)) return true;
    MapDelta delta;
    delta.version = 2;
    delta.added_keyframes.push_back(KeyFrameWith(kKeyFrames + 1, 8));
    EXPECT_TRUE(store_->Apply(target_.map.id, target_.session, delta).ok());
    return true;
  };
  expect_failure(rewrite, change_meanwhile, absl::StatusCode::kAborted);
  EXPECT_EQ(store_->GetMap("target")->keyframe_count, static_cast<uint64_t>(kKeyFrames + 1));
}

TEST_P(RewriteContract, MapsTooLargeTogetherAreNotLoaded) {
  StoreBoth(SensorType::kStereo, SensorType::kStereo);
  const auto alone = LoadMap(*store_, target_.map.id, RingWorld::ScaleInfo(), kEnough);
  ASSERT_TRUE(alone.ok()) << alone.status();
  const auto both = LoadJoinedMaps(*store_, target_.map.id, source_.map.id, RingWorld::ScaleInfo(),
                                   alone->memory_bytes * 3 / 2, {}, false);
  EXPECT_TRUE(absl::IsResourceExhausted(both.status())) << both.status();
}

INSTANTIATE_TEST_SUITE_P(Backends, RewriteContract, ::testing::ValuesIn(AllBackends()), BackendName);

}  // namespace
}  // namespace semmap::storage
