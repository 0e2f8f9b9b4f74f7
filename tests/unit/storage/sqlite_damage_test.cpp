// Files that are not ours, not whole or not sound, and disks and locks that fail: a status each time, never a
// crash.
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>

#include <fstream>
#include <random>

#include "delta_generator.h"
#include "storage_test_support.h"

namespace semmap::storage {
namespace {

class SqliteDamage : public testing::Test {
 protected:
  std::string path() const { return dir_.File("maps.db"); }

  // A closed database with one map of some size.
  void MakeMap(int deltas = 20) {
    const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path()));
    map_ = store->CreateMap(MapNamed("m"))->id;
    session_ = store->StartSession(SessionOf(map_, "s"))->id;
    DeltaGenerator generator(5);
    for (int i = 0; i < deltas; ++i) ASSERT_TRUE(store->Apply(map_, session_, generator.Next()).ok());
    keyframe_ = generator.model().keyframes.begin()->second.id;
  }

  // Changes the closed database behind the store's back.
  void Sql(const std::string& sql) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path().c_str(), &database), SQLITE_OK);
    char* message = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK) << message;
    sqlite3_close(database);
  }

  // Everything that reads; the statuses, in which only known codes may turn up.
  std::vector<absl::StatusCode> ReadEverything(MapStore& store) {
    std::vector<absl::StatusCode> codes;
    const auto note = [&](const absl::Status& status) { codes.push_back(status.code()); };
    note(store.GetMap("m").status());
    note(store.GetMap(map_).status());
    note(store.ListMaps({}).status());
    note(store.GetSession("s").status());
    note(store.ListSessions(map_, SessionId(), 0).status());
    note(store.ForEachMapPoint(map_, {}, [](const MapPointRecord&) { return true; }));
    MapPointQuery near;
    near.box = Eigen::AlignedBox3d(Eigen::Vector3d(-9, -9, -9), Eigen::Vector3d(9, 9, 9));
    note(store.ForEachMapPoint(map_, near, [](const MapPointRecord&) { return true; }));
    note(store.ForEachKeyFrame(map_, {.with_features = true}, [](const KeyFrameEntry&) { return true; }));
    note(store.GetKeyFrame(map_, keyframe_).status());
    note(store.GetObservations(map_, keyframe_).status());
    note(store.ForEachTrajectoryPose(map_, {}, [](const TrajectoryPose&) { return true; }));
    note(store.Summarize(map_).status());
    note(store.CheckIntegrity(map_, 10).status());
    return codes;
  }

  absl::StatusCode OpenCode() { return OpenMapStore(ConfigFor(path())).status().code(); }

  TempDir dir_;
  MapId map_;
  SessionId session_;
  KeyFrameId keyframe_;
};

TEST_F(SqliteDamage, UrisNobodyCanOpen) {
  for (const char* uri : {"", "sqlite:", "sqlite://", "postgresql://host/db", "/tmp/x.db",
                          "sqlite::memory:", "sqlite:file:x?mode=memory"}) {
    StorageConfig config;
    config.uri = uri;
    EXPECT_TRUE(absl::IsInvalidArgument(OpenMapStore(config).status())) << uri;
  }
  EXPECT_TRUE(absl::IsPermissionDenied(OpenMapStore(ConfigFor(dir_.File("no/such/dir.db"))).status()));
}

TEST_F(SqliteDamage, OtherBackendsCanRegister) {
  const auto factory = [](const StorageConfig& config) -> absl::StatusOr<std::unique_ptr<MapStore>> {
    return absl::UnimplementedError(config.uri);
  };
  ASSERT_TRUE(RegisterMapStoreBackend("test", factory).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(RegisterMapStoreBackend("test", factory)));
  EXPECT_TRUE(absl::IsAlreadyExists(RegisterMapStoreBackend("sqlite", factory)));
  EXPECT_TRUE(absl::IsInvalidArgument(RegisterMapStoreBackend("", factory)));
  StorageConfig config;
  config.uri = "test:whatever";
  EXPECT_TRUE(absl::IsUnimplemented(OpenMapStore(config).status()));
}

TEST_F(SqliteDamage, ForeignFilesAreRefusedUntouched) {
  const std::string text = "once upon a time there was a file that was no database\n";
  std::ofstream(path()) << text;
  EXPECT_EQ(OpenCode(), absl::StatusCode::kFailedPrecondition);
  std::ifstream file(path());
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), text);
  std::filesystem::remove(path());
  Sql("CREATE TABLE songs (title TEXT)");
  EXPECT_EQ(OpenCode(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(SqliteDamage, NewerVersionIsRefused) {
  MakeMap(1);
  Sql("PRAGMA user_version=9999");
  const absl::Status status = OpenMapStore(ConfigFor(path())).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("newer"));
}

TEST_F(SqliteDamage, EmptyFileBecomesADatabase) {
  std::ofstream(path()).flush();
  EXPECT_EQ(OpenCode(), absl::StatusCode::kOk);
}

TEST_F(SqliteDamage, TruncatedFilesAreRefused) {
  MakeMap();
  const auto size = std::filesystem::file_size(path());
  for (const auto cut :
       {size - 4096, size / 2, uintmax_t{8192}, uintmax_t{4096}, uintmax_t{1000}, uintmax_t{100}}) {
    std::filesystem::resize_file(path(), cut);
    const absl::StatusCode code = OpenCode();
    EXPECT_TRUE(code == absl::StatusCode::kDataLoss) << cut << ": " << absl::StatusCodeToString(code);
  }
}

TEST_F(SqliteDamage, UndecodableBlobsAreDataLossAndFindings) {
  struct Damage {
    const char* sql;
    const char* finding;
    std::function<absl::Status(MapStore&)> read;
  };
  const auto keyframe = [this](MapStore& store) { return store.GetKeyFrame(map_, keyframe_).status(); };
  const auto observations = [this](MapStore& store) {
    return store.GetObservations(map_, keyframe_).status();
  };
  const auto points = [this](MapStore& store) {
    return store.ForEachMapPoint(map_, {}, [](const MapPointRecord&) { return true; });
  };
  const auto trajectory = [this](MapStore& store) {
    return store.ForEachTrajectoryPose(map_, {}, [](const TrajectoryPose&) { return true; });
  };
  const auto map = [this](MapStore& store) { return store.GetMap(map_).status(); };
  const auto session = [this](MapStore& store) { return store.GetSession(map_, session_).status(); };
  const std::vector<Damage> damages = {
      {"UPDATE keyframe_features SET features = substr(features, 1, length(features) - 1)", "undecodable",
       keyframe},
      {"UPDATE keyframe_features SET features = x''", "undecodable", keyframe},
      {"DELETE FROM keyframe_features", "undecodable", keyframe},
      {"UPDATE keyframes SET keypoint_count = keypoint_count + 1", "undecodable", keyframe},
      {"UPDATE keyframes SET map_from_camera = zeroblob(56)", "undecodable", keyframe},
      {"UPDATE keyframe_observations SET observations = x'01FFFFFFFF0F'", "undecodable", observations},
      {"UPDATE points SET appearance = CAST(x'7F' || substr(appearance, 2) AS BLOB)", "undecodable", points},
      {"UPDATE points SET semantic_class = 256", "undecodable", points},
      {"UPDATE frames SET keyframe_from_camera = zeroblob(56)", "undecodable", trajectory},
      {"UPDATE maps SET rig = x'00'", "undecodable", map},
      {"UPDATE sessions SET rig = x'00'", "undecodable", session},
  };
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.sql);
    std::filesystem::remove(path());
    MakeMap();
    Sql(damage.sql);
    const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path()));
    EXPECT_TRUE(absl::IsDataLoss(damage.read(*store))) << damage.read(*store);
    EXPECT_THAT(Findings(*store, map_), testing::HasSubstr(damage.finding));
    ReadEverything(*store);
  }
}

// What can be done to the rows, and what a check calls it.
const std::pair<const char*, const char*> kContradictions[] = {
    {"DELETE FROM points WHERE point_id % 3 = 0", "dangling-observation"},
    {"UPDATE points SET observation_count = observation_count + 1", "count-mismatch"},
    {"UPDATE points SET x = 9e999", "not-finite"},
    {"UPDATE points SET x = x + 1000", "wrong-cell"},
    {"UPDATE points SET reference_keyframe_id = 999999", "dangling-reference"},
    {"DELETE FROM point_cells", "not-indexed"},
    {"INSERT INTO point_cells SELECT NULL, map_min, map_max, x_min, x_max, y_min, y_max, z_min, z_max "
     "FROM point_cells",
     "index-structure"},
    {"DELETE FROM keyframe_cells", "not-indexed"},
    {"UPDATE keyframe_cells SET x_min = x_min - 5", "wrong-cell"},
    {"DELETE FROM point_cells_rowid", "index-structure"},
    {"UPDATE keyframes SET parent_id = 999999", "dangling-parent"},
    {"UPDATE keyframes SET parent_id = keyframe_id", "cycle"},
    {"UPDATE keyframes SET observation_count = 0", "count-mismatch"},
    {"UPDATE maps SET keyframe_count = 0", "count-mismatch"},
    {"UPDATE maps SET point_count = 0", "count-mismatch"},
    {"UPDATE maps SET last_point_id = 0, last_keyframe_id = 0", "id-out-of-range"},
    {"UPDATE sessions SET stored_frames = 0", "count-mismatch"},
    {"UPDATE frames SET keyframe_id = 999999", "foreign-key"},
};

TEST_F(SqliteDamage, ContradictionsAreRepaired) {
  std::vector<std::string> damages = {
      "UPDATE keyframe_features SET features = substr(features, 1, length(features) - 1) WHERE keyframe_id % "
      "2 = 0",
      "DELETE FROM keyframe_features WHERE keyframe_id % 2 = 0",
      "UPDATE keyframes SET map_from_camera = zeroblob(56) WHERE keyframe_id % 3 = 0",
      "UPDATE keyframe_observations SET observations = x'01FFFFFFFF0F'",
      "UPDATE points SET semantic_class = 256 WHERE point_id % 2 = 0",
      "UPDATE frames SET keyframe_from_camera = zeroblob(56) WHERE sequence % 2 = 0",
  };
  for (const auto& [sql, finding] : kContradictions) {
    // The file's own structure is not in a map's power.
    if (std::string_view(sql) != "DELETE FROM point_cells_rowid") damages.emplace_back(sql);
  }
  for (const std::string& sql : damages) {
    SCOPED_TRACE(sql);
    std::filesystem::remove(path());
    MakeMap();
    Sql(sql);
    const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path()));
    EXPECT_NE(Findings(*store, map_), "");
    const absl::Status status = store->RepairMap(map_);
    EXPECT_TRUE(status.ok()) << status;
    EXPECT_EQ(Findings(*store, map_), "");
  }
}

TEST_F(SqliteDamage, ContradictionsAreFindings) {
  for (const auto& [sql, finding] : kContradictions) {
    SCOPED_TRACE(sql);
    std::filesystem::remove(path());
    MakeMap();
    Sql(sql);
    const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path()));
    const absl::StatusOr<std::vector<IntegrityFinding>> findings = store->CheckIntegrity(map_, 1000);
    ASSERT_TRUE(findings.ok()) << findings.status();
    std::set<std::string> kinds;
    for (const IntegrityFinding& found : *findings) kinds.insert(found.kind);
    EXPECT_THAT(kinds, testing::Contains(finding));
  }
}

TEST_F(SqliteDamage, FlippedBytesNeverCrash) {
  MakeMap(10);
  std::ifstream file(path(), std::ios::binary);
  const std::string good(std::istreambuf_iterator<char>(file), {});
  std::mt19937 random(17);
  int noticed = 0;
  for (int round = 0; round < 60; ++round) {
    std::string bad = good;
    // Now and then in the header page, where it hurts most.
    const size_t range = round % 4 == 0 ? 4096 : bad.size();
    for (int i = 0; i < 20; ++i) bad[random() % range] = static_cast<char>(random());
    std::ofstream(path(), std::ios::binary) << bad;
    std::filesystem::remove(path() + "-wal");
    absl::StatusOr<std::unique_ptr<MapStore>> store = OpenMapStore(ConfigFor(path()));
    if (!store.ok()) {
      ++noticed;
      continue;
    }
    ReadEverything(**store);
    DeltaGenerator generator(6);
    (void)(*store)->Apply(map_, session_, generator.Next());
    noticed += Findings(**store, map_).empty() ? 0 : 1;
  }
  // The others hit what has no structure: a descriptor is as good as another.
  EXPECT_GT(noticed, 20);
}

TEST_F(SqliteDamage, SomebodyElsesLockIsUnavailable) {
  MakeMap(1);
  StorageConfig config = ConfigFor(path());
  config.busy_timeout_ms = 30;
  const std::unique_ptr<MapStore> store = OpenOrDie(config);
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(path().c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  EXPECT_TRUE(absl::IsUnavailable(store->CreateMap(MapNamed("x")).status()));
  EXPECT_TRUE(store->GetMap("m").ok());  // reading goes on
  ASSERT_EQ(sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr), SQLITE_OK);
  EXPECT_TRUE(store->CreateMap(MapNamed("x")).ok());
  sqlite3_close(other);
}

TEST_F(SqliteDamage, FullDiskIsReportedAndPasses) {
  MakeMap(1);
  StorageConfig config = ConfigFor(path());
  config.keyframe_keypoints = 65535;
  const std::unique_ptr<MapStore> store = OpenOrDie(config);
  const MapId map = store->CreateMap(MapNamed("full"))->id;
  const SessionId session = store->StartSession(SessionOf(map, "full"))->id;
  MapDelta delta;
  delta.version = 1;
  delta.added_keyframes.push_back(KeyFrameWith(1, 60000));
  // A limit on the size of files stands for the end of the disk.
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_handler = signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1 << 20, old_limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const absl::Status full = store->Apply(map, session, delta);
  const absl::StatusOr<MapInfo> meanwhile = store->GetMap(map);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old_limit), 0);
  signal(SIGXFSZ, old_handler);

  EXPECT_TRUE(absl::IsResourceExhausted(full)) << full;
  ASSERT_TRUE(meanwhile.ok()) << meanwhile.status();
  EXPECT_EQ(meanwhile->keyframe_count, 0);
  EXPECT_EQ(Findings(*store, map), "");
  const absl::Status again = store->Apply(map, session, delta);
  EXPECT_TRUE(again.ok()) << again;
  EXPECT_EQ(store->GetMap(map)->keyframe_count, 1);
}

TEST_F(SqliteDamage, DeletionCutShortIsFinishedAtTheNextOpening) {
  MakeMap();
  Sql("UPDATE maps SET name = NULL; UPDATE sessions SET name = NULL; DELETE FROM frames WHERE sequence % 2 = "
      "0;");
  const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path()));
  EXPECT_TRUE(store->ListMaps({})->empty());
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path().c_str(), &database), SQLITE_OK);
  for (const char* table : {"maps", "sessions", "keyframes", "keyframe_features", "keyframe_observations",
                            "points", "frames", "point_cells", "keyframe_cells"}) {
    sqlite3_stmt* count = nullptr;
    const std::string sql = std::string("SELECT count(*) FROM ") + table;
    ASSERT_EQ(sqlite3_prepare_v2(database, sql.c_str(), -1, &count, nullptr), SQLITE_OK);
    ASSERT_EQ(sqlite3_step(count), SQLITE_ROW);
    EXPECT_EQ(sqlite3_column_int(count, 0), 0) << table;
    sqlite3_finalize(count);
  }
  sqlite3_close(database);
}

}  // namespace
}  // namespace semmap::storage
