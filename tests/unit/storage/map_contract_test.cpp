// The contract of MapStore: maps and sessions.
#include <limits>

#include "map_store_contract.h"

namespace semmap::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

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

TEST_P(MapStoreContract, WhatIsSaidAboutAMapChanges) {
  NewMap wanted = MapNamed("town");
  wanted.display_name = "Die Stadt \xC3\xBC";
  wanted.labels = {{"a", ""}, {"b", "x=y"}};
  wanted.anchor = GeoAnchor{1, 2, 3, {}, GeoAnchor::Source::kFitted, 0.7};
  const absl::StatusOr<MapInfo> created = store_->CreateMap(wanted);
  ASSERT_TRUE(created.ok()) << created.status();
  Reopen();
  const absl::StatusOr<MapInfo> before = store_->GetMap("town");
  ASSERT_TRUE(before.ok()) << before.status();
  EXPECT_EQ(before->display_name, wanted.display_name);
  EXPECT_EQ(before->labels, wanted.labels);
  EXPECT_EQ(before->anchor->source, GeoAnchor::Source::kFitted);
  EXPECT_EQ(before->anchor->rms_error_m, 0.7);
  const absl::StatusOr<MapInfo> changed = store_->UpdateMap(before->id, {.labels = Labels{{"c", "d"}}});
  ASSERT_TRUE(changed.ok()) << changed.status();
  EXPECT_EQ(changed->labels, (Labels{{"c", "d"}}));
  EXPECT_EQ(changed->display_name, wanted.display_name);
  EXPECT_EQ(changed->anchor->altitude_m, 3);
  EXPECT_EQ(changed->revision, before->revision + 1);
  EXPECT_EQ(changed->version, before->version);
  const MapChanges outdated{.display_name = "x",
                            .expected = MapChanges::State{before->version, before->revision}};
  EXPECT_TRUE(absl::IsAborted(store_->UpdateMap(before->id, outdated).status()));
  EXPECT_EQ(store_->GetMap("town")->display_name, wanted.display_name);
  const MapChanges current{.display_name = "x",
                           .expected = MapChanges::State{changed->version, changed->revision}};
  EXPECT_TRUE(store_->UpdateMap(before->id, current).ok());
  const absl::StatusOr<MapInfo> copy = store_->CopyMap(before->id, "copy", 5, nullptr);
  ASSERT_TRUE(copy.ok()) << copy.status();
  EXPECT_EQ(copy->display_name, "x");
  EXPECT_EQ(copy->labels, (Labels{{"c", "d"}}));
  EXPECT_EQ(copy->anchor->rms_error_m, 0.7);
}

TEST_P(MapStoreContract, WhatIsSaidAboutAMapHasBounds) {
  StartMap();
  const auto code = [&](const MapChanges& changes) {
    return store_->UpdateMap(map_, changes).status().code();
  };
  EXPECT_EQ(code({.display_name = std::string(1025, 'x')}), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code({.labels = Labels{{"", "x"}}}), absl::StatusCode::kInvalidArgument);
  Labels many;
  for (int i = 0; i < 65; ++i) many.emplace(std::to_string(i), "x");
  EXPECT_EQ(code({.labels = many}), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code({.labels = Labels{{"a", std::string(1021, 'x')}}}), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(absl::IsNotFound(store_->UpdateMap(MapId(99), {.display_name = "x"}).status()));
  EXPECT_EQ(store_->GetMap(map_)->revision, 0U);
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

}  // namespace

INSTANTIATE_TEST_SUITE_P(Backends, MapStoreContract, testing::ValuesIn(AllBackends()), BackendName);

}  // namespace semmap::storage
