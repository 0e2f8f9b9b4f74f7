#include <atomic>
#include <filesystem>
#include <thread>

#include "delta_generator.h"
#include "map_store_contract.h"

// Renaming, copying, exporting, importing, repairing and backing up.
namespace semmap::storage {
namespace {

class MapCare : public MapStoreContract {
 protected:
  // A map of some size.
  void GrowMap(int deltas = 60) {
    StartMap();
    DeltaGenerator generator(31);
    for (int i = 0; i < deltas; ++i) ASSERT_TRUE(store_->Apply(map_, session_, generator.Next()).ok());
  }

  void ExpectSameContents(MapStore& other, MapId copy) {
    const auto keyframes = AllKeyFrames(*store_, map_, {.with_features = true});
    const auto copied = AllKeyFrames(other, copy, {.with_features = true});
    ASSERT_EQ(copied.size(), keyframes.size());
    for (size_t i = 0; i < keyframes.size(); ++i) {
      const KeyFrameRecord& record = keyframes[i].record;
      EXPECT_EQ(copied[i].record.id, record.id);
      EXPECT_EQ(copied[i].record.parent, record.parent);
      EXPECT_TRUE(SamePose(copied[i].record.map_from_camera, record.map_from_camera));
      EXPECT_TRUE(SameFeatures(*copied[i].record.features, *record.features));
      EXPECT_EQ(other.GetObservations(copy, record.id)->point_of_keypoint,
                store_->GetObservations(map_, record.id)->point_of_keypoint);
    }
    const auto points = AllPoints(*store_, map_);
    const auto copied_points = AllPoints(other, copy);
    ASSERT_EQ(copied_points.size(), points.size());
    for (size_t i = 0; i < points.size(); ++i) EXPECT_TRUE(SamePoint(copied_points[i], points[i]));
    const auto poses = Trajectory(*store_, map_);
    const auto copied_poses = Trajectory(other, copy);
    ASSERT_EQ(copied_poses.size(), poses.size());
    for (size_t i = 0; i < poses.size(); ++i) {
      EXPECT_TRUE(SamePose(copied_poses[i].map_from_camera, poses[i].map_from_camera));
    }
    EXPECT_EQ(Findings(other, copy), "");
  }

  std::vector<std::string> MapNames(MapStore& store) {
    const std::vector<MapInfo> maps = *store.ListMaps({});
    std::vector<std::string> names;
    for (const MapInfo& map : maps) names.push_back(map.name);
    return names;
  }
};

TEST_P(MapCare, RenamedMapIsFoundUnderItsNewName) {
  StartSmallMap();
  const absl::StatusOr<MapInfo> renamed = store_->RenameMap(map_, "village");
  ASSERT_TRUE(renamed.ok()) << renamed.status();
  EXPECT_EQ(renamed->name, "village");
  EXPECT_TRUE(absl::IsNotFound(store_->GetMap("town").status()));
  EXPECT_EQ(store_->GetMap("village")->id, map_);
  EXPECT_EQ(store_->GetSession("session-of-town")->map, map_);
  EXPECT_TRUE(store_->RenameMap(map_, "village").ok());  // to what it is called
  ASSERT_TRUE(store_->CreateMap(MapNamed("town")).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(store_->RenameMap(map_, "town").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->RenameMap(map_, "no name").status()));
  EXPECT_TRUE(absl::IsNotFound(store_->RenameMap(MapId(99), "x").status()));
}

TEST_P(MapCare, CopyHoldsTheSameAndIsItsOwn) {
  ASSERT_TRUE(store_->CreateMap(MapNamed("before")).ok());
  GrowMap();
  double last_progress = -1;
  const absl::StatusOr<MapInfo> copy = store_->CopyMap(map_, "copy", 77, [&](double progress) {
    EXPECT_GE(progress, last_progress);
    EXPECT_LE(progress, 1);
    last_progress = progress;
    return true;
  });
  ASSERT_TRUE(copy.ok()) << copy.status();
  EXPECT_EQ(last_progress, 1);
  EXPECT_EQ(copy->created_at, 77);
  const absl::StatusOr<MapInfo> original = store_->GetMap(map_);
  EXPECT_EQ(copy->keyframe_count, original->keyframe_count);
  EXPECT_EQ(copy->point_count, original->point_count);
  ExpectSameContents(*store_, copy->id);
  EXPECT_EQ(store_->ListSessions(copy->id, SessionId(), 0)->size(), 1U);
  EXPECT_EQ(Findings(*store_, map_), "");
  ASSERT_TRUE(store_->DeleteMap(map_).ok());
  Reopen();
  EXPECT_EQ(AllPoints(*store_, copy->id).size(), copy->point_count);
  EXPECT_EQ(Findings(*store_, copy->id), "");
}

// A backup beside a running server opens the store a second time: a copy under way is no remains of a crash.
TEST_P(MapCare, WhoOpensTheStoreMeanwhileLeavesTheCopyAlone) {
  GrowMap();
  int opened = 0;
  const absl::StatusOr<MapInfo> copy = store_->CopyMap(map_, "copy", 77, [&](double) {
    const auto other = OpenMapStore(config_);
    EXPECT_TRUE(other.ok()) << other.status();
    ++opened;
    return true;
  });
  ASSERT_TRUE(copy.ok()) << copy.status();
  EXPECT_GT(opened, 1);
  ExpectSameContents(*store_, copy->id);
}

TEST_P(MapCare, CopyGrowsOn) {
  StartSmallMap();
  const absl::StatusOr<MapInfo> copy = store_->CopyMap(map_, "copy", 77, nullptr);
  ASSERT_TRUE(copy.ok()) << copy.status();
  const absl::StatusOr<SessionInfo> session = store_->StartSession(SessionOf(copy->id, "later"));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_GT(session->id, session_);
  MapDelta delta;
  delta.version = 1;
  delta.added_keyframes.push_back(KeyFrameWith(4, 8));
  EXPECT_TRUE(store_->Apply(copy->id, session->id, delta).ok());
  EXPECT_EQ(store_->GetMap(copy->id)->keyframe_count, 4U);
  EXPECT_EQ(store_->GetMap(map_)->keyframe_count, 3U);
}

TEST_P(MapCare, CopyThatFailsLeavesNothing) {
  GrowMap();
  ASSERT_TRUE(store_->CreateMap(MapNamed("taken")).ok());
  const auto code = [&](MapId map, const char* name, const ProgressVisitor& progress) {
    return store_->CopyMap(map, name, 77, progress).status().code();
  };
  EXPECT_EQ(code(map_, "taken", nullptr), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(code(map_, "no name", nullptr), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(MapId(99), "copy", nullptr), absl::StatusCode::kNotFound);
  EXPECT_EQ(code(map_, "copy", [](double) { return false; }), absl::StatusCode::kCancelled);
  const auto change_meanwhile = [&](double) {
    MapDelta delta;
    delta.version = store_->GetSession(map_, session_)->last_delta_version + 1;
    return store_->Apply(map_, session_, delta).ok();
  };
  EXPECT_EQ(code(map_, "copy", change_meanwhile), absl::StatusCode::kAborted);
  EXPECT_EQ(code(map_, "copy", [&](double) { return store_->DeleteMap(map_).ok() || true; }),
            absl::StatusCode::kAborted);
  Reopen();
  EXPECT_EQ(MapNames(*store_), std::vector<std::string>{"taken"});
}

TEST_P(MapCare, AnExportedMapIsTheSameInAnotherStore) {
  ASSERT_TRUE(store_->CreateMap(MapNamed("before")).ok());
  GrowMap();
  GeoAnchor anchor{48.1, 11.6, 519, {}};
  ASSERT_TRUE(store_->SetAnchor(map_, anchor).ok());
  const std::string path = dir_.File("town.semmap");
  double last_progress = -1;
  const absl::Status exported = store_->ExportMap(map_, path, [&](double progress) {
    EXPECT_GE(progress, last_progress);
    last_progress = progress;
    return true;
  });
  ASSERT_TRUE(exported.ok()) << exported;
  EXPECT_EQ(last_progress, 1);
  const std::unique_ptr<MapStore> other = OpenOrDie(ConfigFor(dir_.File("other.db")));
  const absl::StatusOr<MapInfo> imported = other->ImportMap(path, "village", 99, nullptr);
  ASSERT_TRUE(imported.ok()) << imported.status();
  EXPECT_EQ(imported->name, "village");
  EXPECT_EQ(imported->created_at, 99);
  EXPECT_EQ(imported->version, store_->GetMap(map_)->version);
  EXPECT_EQ(imported->point_count, store_->GetMap(map_)->point_count);
  ASSERT_TRUE(imported->anchor.has_value());
  EXPECT_EQ(imported->anchor->latitude_deg, 48.1);
  ExpectSameContents(*other, imported->id);
  EXPECT_EQ(other->GetSession("session-of-town")->map, imported->id);
}

TEST_P(MapCare, AnExportedMapIsAStoreItself) {
  GrowMap();
  const std::string path = dir_.File("town.semmap");
  ASSERT_TRUE(store_->ExportMap(map_, path, nullptr).ok());
  const std::unique_ptr<MapStore> other = OpenOrDie(ConfigFor(path));
  EXPECT_EQ(MapNames(*other), std::vector<std::string>{"town"});
  ExpectSameContents(*other, other->GetMap("town")->id);
}

TEST_P(MapCare, ImportedBesideItsOriginalItGrowsOn) {
  StartSmallMap();
  const std::string path = dir_.File("town.semmap");
  ASSERT_TRUE(store_->ExportMap(map_, path, nullptr).ok());
  const absl::StatusOr<MapInfo> imported = store_->ImportMap(path, "again", 99, nullptr);
  ASSERT_TRUE(imported.ok()) << imported.status();
  ExpectSameContents(*store_, imported->id);
  // Its session's name was taken.
  EXPECT_EQ(store_->GetSession("session-of-town")->map, map_);
  const auto session = store_->StartSession(SessionOf(imported->id, "later"));
  ASSERT_TRUE(session.ok()) << session.status();
  MapDelta delta;
  delta.version = 1;
  delta.added_keyframes.push_back(KeyFrameWith(4, 8));
  EXPECT_TRUE(store_->Apply(imported->id, session->id, delta).ok());
  EXPECT_EQ(Findings(*store_, imported->id), "");
  EXPECT_EQ(store_->GetMap(map_)->keyframe_count, 3U);
}

TEST_P(MapCare, AnExportWhileOthersWriteIsOneState) {
  StartMap();
  DeltaGenerator generator(33);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(store_->Apply(map_, session_, generator.Next()).ok());
  const std::string path = dir_.File("town.semmap");
  const absl::Status exported = store_->ExportMap(
      map_, path, [&](double) { return store_->Apply(map_, session_, generator.Next()).ok(); });
  ASSERT_TRUE(exported.ok()) << exported;
  const std::unique_ptr<MapStore> file = OpenOrDie(ConfigFor(path));
  EXPECT_EQ(file->GetMap("town")->version, 20U);
  EXPECT_EQ(Findings(*file, file->GetMap("town")->id), "");
}

TEST_P(MapCare, ExportsAndImportsThatFailLeaveNothing) {
  GrowMap();
  const std::string path = dir_.File("town.semmap");
  const auto stop = [](double) { return false; };
  EXPECT_TRUE(absl::IsNotFound(store_->ExportMap(MapId(99), path, nullptr)));
  EXPECT_TRUE(absl::IsCancelled(store_->ExportMap(map_, path, stop)));
  EXPECT_FALSE(store_->ExportMap(map_, dir_.File("missing/town.semmap"), nullptr).ok());
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  ASSERT_TRUE(store_->ExportMap(map_, path, nullptr).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(store_->ExportMap(map_, path, nullptr)));
  EXPECT_TRUE(absl::IsAlreadyExists(store_->ImportMap(path, "town", 99, nullptr).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->ImportMap(path, "no name", 99, nullptr).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->ImportMap(dir_.File("none"), "x", 99, nullptr).status()));
  EXPECT_TRUE(absl::IsCancelled(store_->ImportMap(path, "again", 99, stop).status()));
  EXPECT_EQ(MapNames(*store_), std::vector<std::string>{"town"});
  Reopen();
  EXPECT_EQ(MapNames(*store_), std::vector<std::string>{"town"});
}

TEST_P(MapCare, RepairLeavesASoundMapAlone) {
  GrowMap();
  const std::string path = dir_.File("before.db");
  ASSERT_TRUE(store_->Backup(path, nullptr).ok());
  ASSERT_TRUE(store_->RepairMap(map_).ok());
  ExpectSameContents(*OpenOrDie(ConfigFor(path)), map_);
  EXPECT_EQ(Findings(*store_, map_), "");
  EXPECT_TRUE(absl::IsNotFound(store_->RepairMap(MapId(99))));
}

TEST_P(MapCare, RepairRemovesWhatReferencesNothing) {
  StartSmallMap();
  MapDelta delta;
  delta.removed_points = {MapPointId(2)};  // keyframes 1 and 2 still see it
  ASSERT_TRUE(Apply(delta).ok());
  EXPECT_NE(Findings(*store_, map_), "");
  ASSERT_TRUE(store_->RepairMap(map_).ok());
  EXPECT_EQ(Findings(*store_, map_), "");
  EXPECT_THAT(PointIds(*store_, map_), testing::ElementsAre(1, 3, 4));
  EXPECT_EQ(store_->GetObservations(map_, KeyFrameId(1))->point_of_keypoint[3], MapPointId(3));
}

TEST_P(MapCare, BackupIsAStoreOfItsOwn) {
  GrowMap();
  const std::string path = dir_.File("backup.db");
  const absl::Status status = store_->Backup(path, nullptr);
  ASSERT_TRUE(status.ok()) << status;
  ExpectSameContents(*OpenOrDie(ConfigFor(path)), map_);
  EXPECT_TRUE(absl::IsAlreadyExists(store_->Backup(path, nullptr)));
  EXPECT_FALSE(store_->Backup(dir_.File("missing/backup.db"), nullptr).ok());
  const std::string cancelled = dir_.File("cancelled.db");
  EXPECT_TRUE(absl::IsCancelled(store_->Backup(cancelled, [](double) { return false; })));
  EXPECT_FALSE(std::filesystem::exists(cancelled));
  EXPECT_FALSE(std::filesystem::exists(cancelled + ".part"));
}

TEST_P(MapCare, BackupWhileOthersWriteIsOneState) {
  StartMap();
  std::atomic<bool> stop = false;
  std::atomic<uint64_t> written = 0;
  std::thread writer([&] {
    DeltaGenerator generator(32);
    while (!stop) {
      if (!store_->Apply(map_, session_, generator.Next()).ok()) return;
      ++written;
    }
  });
  while (written < 20) std::this_thread::yield();
  for (int round = 0; round < 5; ++round) {
    const std::string path = dir_.File("backup" + std::to_string(round) + ".db");
    const uint64_t before = written;
    const absl::Status status = store_->Backup(path, nullptr);
    ASSERT_TRUE(status.ok()) << status;
    const std::unique_ptr<MapStore> backup = OpenOrDie(ConfigFor(path));
    EXPECT_EQ(Findings(*backup, map_), "");
    EXPECT_GE(backup->GetMap(map_)->version, before);
  }
  stop = true;
  writer.join();
}

TEST_P(MapCare, EveryChangeIsDated) {
  const auto now = [] {
    return std::chrono::system_clock::now().time_since_epoch() / std::chrono::seconds(1);
  };
  const int64_t before = now();
  StartMap();
  EXPECT_EQ(store_->GetMap(map_)->updated_at, MapNamed("town").created_at);
  ASSERT_TRUE(Apply(SmallDelta()).ok());
  const std::optional<TimestampNs> updated = store_->GetMap(map_)->updated_at;
  ASSERT_TRUE(updated.has_value());
  EXPECT_GE(*updated, before * 1'000'000'000);
  EXPECT_LE(*updated, now() * 1'000'000'000);
}

INSTANTIATE_TEST_SUITE_P(Backends, MapCare, testing::ValuesIn(AllBackends()), BackendName);

}  // namespace
}  // namespace semmap::storage
