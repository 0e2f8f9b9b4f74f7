#include "version_one.h"

#include <memory>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/query.h"

namespace semmap::kill_test {
namespace {

using storage::sqlite::Connection;

constexpr char kCopy[] = R"(
PRAGMA foreign_keys=OFF;
BEGIN;
INSERT INTO main.maps (map_id, name, created_at, rig, scale_known, latitude_deg, longitude_deg, altitude_m, enu_from_map,
                       keyframe_count, point_count, version, last_keyframe_id, last_point_id, last_session_id, cell_size)
  SELECT map_id, name, created_at, rig, scale_known, latitude_deg, longitude_deg, altitude_m, enu_from_map,
         keyframe_count, point_count, version, last_keyframe_id, last_point_id, last_session_id, cell_size FROM now.maps;
INSERT INTO main.sessions SELECT * FROM now.sessions;
INSERT INTO main.keyframes SELECT * FROM now.keyframes;
INSERT INTO main.keyframe_features SELECT map_id, keyframe_id, features FROM now.keyframe_features;
INSERT INTO main.keyframe_observations SELECT map_id, keyframe_id, observations FROM now.keyframe_observations;
INSERT INTO main.points (map_id, point_id, cell_key, session_id, x, y, z, semantic_class, class_confidence,
                         observation_count, first_seen, last_seen, reference_keyframe_id, appearance)
  SELECT map_id, point_id, cell_key, session_id, x, y, z, semantic_class, class_confidence,
         observation_count, first_seen, last_seen, reference_keyframe_id, appearance FROM now.points;
INSERT INTO main.frames SELECT * FROM now.frames;
INSERT INTO main.point_cells SELECT * FROM now.point_cells;
INSERT INTO main.keyframe_cells SELECT * FROM now.keyframe_cells;
COMMIT;
DETACH now;
)";

absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& path) {
  storage::sqlite::ConnectionOptions options;
  options.path = path;
  return Connection::Open(options);
}

}  // namespace

absl::Status WriteVersionOne(const std::string& present, const std::string& old) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Connection> connection, Open(old));
  const auto first = storage::sqlite::EmbeddedMigrations().first(1);
  SEMMAP_RETURN_IF_ERROR(storage::sqlite::MigrateDatabase(*connection, first));
  SEMMAP_RETURN_IF_ERROR(connection->Execute(absl::StrCat("ATTACH '", present, "' AS now")));
  return connection->Execute(kCopy);
}

absl::StatusOr<int64_t> SchemaVersion(const std::string& path) {
  static constexpr char kSelect[] = "PRAGMA user_version";
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Connection> connection, Open(path));
  return storage::sqlite::QueryInteger(*connection, kSelect);
}

}  // namespace semmap::kill_test
