// Map files that are not whole, not sound, or made to do harm: refused with a reason, and nothing is left.
#include <sqlite3.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "delta_generator.h"
#include "storage_test_support.h"

namespace semmap::storage {
namespace {

class SqliteMapFile : public testing::Test {
 protected:
  SqliteMapFile() {
    const std::unique_ptr<MapStore> source = OpenOrDie(ConfigFor(dir_.File("source.db")));
    const MapId map = source->CreateMap(MapNamed("town"))->id;
    const SessionId session = source->StartSession(SessionOf(map, "s"))->id;
    DeltaGenerator generator(41);
    for (int i = 0; i < 30; ++i) EXPECT_TRUE(source->Apply(map, session, generator.Next()).ok());
    EXPECT_TRUE(source->ExportMap(map, path(), nullptr).ok());
    std::ifstream file(path(), std::ios::binary);
    whole_.assign(std::istreambuf_iterator<char>(file), {});
  }

  std::string path() const { return dir_.File("town.semmap"); }

  void WriteFile(const std::string& bytes) const {
    for (const char* suffix : {"-wal", "-shm", "-journal"}) std::filesystem::remove(path() + suffix);
    std::ofstream(path(), std::ios::binary | std::ios::trunc) << bytes;
  }

  // Changes the file from outside.
  void Sql(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path().c_str(), &database), SQLITE_OK);
    char* message = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK) << message;
    sqlite3_close(database);
  }

  absl::Status Import() { return store_->ImportMap(path(), "town", 99, nullptr).status(); }

  void ExpectRefused(const std::string& what) {
    const absl::Status status = Import();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << what << ": " << status;
    EXPECT_EQ(std::string(status.message()).find(path()), std::string::npos)
        << "tells where it lies: " << status;
    EXPECT_TRUE(store_->ListMaps({})->empty()) << what;
  }

  // The same map again and again: each change begins with a sound file.
  void ExpectRefusedAfter(const std::string& sql) {
    WriteFile(whole_);
    Sql(sql);
    ExpectRefused(sql);
  }

  TempDir dir_;
  std::string whole_;
  std::unique_ptr<MapStore> store_ = OpenOrDie(ConfigFor(dir_.File("maps.db")));
};

TEST_F(SqliteMapFile, SoundOnesAreTaken) { EXPECT_TRUE(Import().ok()); }

TEST_F(SqliteMapFile, FilesThatAreNoMaps) {
  for (const std::string& bytes : {std::string(), std::string("GIF89a"), std::string(100'000, '\0'),
                                   whole_.substr(0, 16), whole_.substr(0, 100)}) {
    WriteFile(bytes);
    ExpectRefused("bytes " + std::to_string(bytes.size()));
  }
}

TEST_F(SqliteMapFile, CutShort) {
  for (int part = 1; part < 20; ++part) {
    WriteFile(whole_.substr(0, whole_.size() * part / 20));
    ExpectRefused(std::to_string(part) + " twentieths");
  }
}

// Whatever becomes of a file whose bits fell over: it is refused, or what came of it is sound.
TEST_F(SqliteMapFile, FallenBits) {
  std::mt19937 random(7);
  int refused = 0;
  constexpr int kFiles = 60;
  for (int i = 0; i < kFiles; ++i) {
    std::string bytes = whole_;
    for (int flip = 0; flip < 20; ++flip)
      bytes[random() % bytes.size()] ^= static_cast<char>(1 << random() % 8);
    WriteFile(bytes);
    const auto map = store_->ImportMap(path(), "town", 99, nullptr);
    if (map.ok()) {
      EXPECT_EQ(Findings(*store_, map->id), "");
      EXPECT_TRUE(store_->DeleteMap(map->id).ok());
    } else {
      ++refused;
      EXPECT_TRUE(absl::IsInvalidArgument(map.status())) << map.status();
    }
  }
  EXPECT_GT(refused, kFiles / 2);
}

TEST_F(SqliteMapFile, ASchemaThatDoesMoreThanStore) {
  ExpectRefusedAfter("CREATE TABLE more (x)");
  ExpectRefusedAfter("CREATE TRIGGER t AFTER UPDATE ON maps BEGIN DELETE FROM points; END");
  ExpectRefusedAfter(
      "CREATE VIEW v AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i FROM n");
  ExpectRefusedAfter(
      "ALTER TABLE frames RENAME TO f; CREATE VIEW frames AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL "
      "SELECT i + 1 "
      "FROM n) SELECT 1 AS map_id, 1 AS session_id, i AS sequence, i AS timestamp, 1 AS keyframe_id, x'' AS "
      "keyframe_from_camera FROM n");
  ExpectRefusedAfter("DROP INDEX points_by_cell");
}

TEST_F(SqliteMapFile, VersionsThatAreUnknown) {
  ExpectRefusedAfter("PRAGMA user_version=0");
  ExpectRefusedAfter("PRAGMA user_version=1");
  ExpectRefusedAfter("PRAGMA user_version=1000");
  ExpectRefusedAfter("PRAGMA application_id=7");
}

TEST_F(SqliteMapFile, NotOneMap) {
  ExpectRefusedAfter("INSERT INTO maps (name, created_at, rig, scale_known) SELECT 'b', 1, rig, 1 FROM maps");
  ExpectRefusedAfter("UPDATE maps SET name = NULL");
  ExpectRefusedAfter("UPDATE maps SET name = 'a/b'");
  ExpectRefusedAfter("PRAGMA foreign_keys=OFF; DELETE FROM maps");
}

TEST_F(SqliteMapFile, ReferencesAndNumbersThatAreWrong) {
  ExpectRefusedAfter("DELETE FROM points WHERE point_key IN (SELECT max(point_key) FROM points)");
  ExpectRefusedAfter("UPDATE maps SET point_count = point_count + 1");
  ExpectRefusedAfter("UPDATE maps SET last_point_id = 1");
  ExpectRefusedAfter("UPDATE points SET x = 9e999 WHERE point_key IN (SELECT max(point_key) FROM points)");
  ExpectRefusedAfter("UPDATE points SET class_confidence = 9e999");
  ExpectRefusedAfter("UPDATE points SET appearance = x'00'");
  ExpectRefusedAfter("UPDATE keyframe_features SET features = x'ffffffffffff'");
  ExpectRefusedAfter("UPDATE keyframes SET parent_id = keyframe_id");
  ExpectRefusedAfter("UPDATE sessions SET name = ''");
  ExpectRefusedAfter("UPDATE sessions SET name = char(7)");
  ExpectRefusedAfter("UPDATE sessions SET rig = x'01'");
  ExpectRefusedAfter(
      "UPDATE maps SET latitude_deg = 91, longitude_deg = 0, altitude_m = 0, enu_from_map = zeroblob(65)");
  ExpectRefusedAfter("DELETE FROM point_cells");
  ExpectRefusedAfter("UPDATE maps SET cell_size = 0");
  ExpectRefusedAfter("UPDATE maps SET cell_size = 1e-300");
  ExpectRefusedAfter("UPDATE maps SET display_name = CAST(x'ff' AS TEXT)");
  ExpectRefusedAfter("UPDATE sessions SET vehicle_id = CAST(x'c328' AS TEXT)");
  ExpectRefusedAfter("UPDATE maps SET labels = x'0103'");
}

}  // namespace
}  // namespace semmap::storage
