#include "storage/sqlite/map_copy.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/cell_grid.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/spatial_index.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {
namespace {

// Rows of a step: small enough that a vehicle's delta does not wait long for the lock.
constexpr int kKeyFramesPerStep = 50;
constexpr int kPointsPerStep = 5000;
constexpr int kFramesPerStep = 5000;

// Statements of a copy; `source` is the schema that the source's tables are in, those of the copy are in
// "main". ?1 is the copy, ?2 the source everywhere. Steps go on behind the greatest key that the copy has.
// Names of sessions are unique in the store, so the copy's stay unset until the map is shown.
struct CopyStatements {
  const char* insert_map;
  const char* sessions;
  const char* keyframes;
  const char* features;
  const char* observations;
  const char* words;
  const char* keyframe_cells;
  const char* points;
  const char* frames;
  const char* name_sessions;
  const char* show;
};

#define SEMMAP_OF_COPIED_KEYFRAMES(source, table)                                               \
  " FROM " source "." table                                                                     \
  " WHERE map_id = ?2 AND keyframe_id > (SELECT coalesce(max(keyframe_id), 0) FROM main." table \
  " WHERE map_id = ?1) AND keyframe_id <= (SELECT max(keyframe_id) FROM main.keyframes WHERE map_id = ?1)"
#define SEMMAP_COPY_STATEMENTS(source)                                                                       \
  {                                                                                                          \
    "INSERT INTO main.maps (created_at, rig, scale_known, latitude_deg, longitude_deg, altitude_m, "         \
    "enu_from_map, anchor_source, anchor_rms_m, display_name, labels, cell_size) "                           \
    "SELECT ?1, rig, scale_known, latitude_deg, longitude_deg, altitude_m, enu_from_map, anchor_source, "    \
    "anchor_rms_m, display_name, labels, cell_size FROM " source ".maps WHERE map_id = ?2",                  \
        "INSERT INTO main.sessions (map_id, session_id, vehicle_id, started_at, ended_at, rig, "             \
        "frames_received, "                                                                                  \
        "frames_tracked, stored_frames, last_durable_sequence, last_delta_version) "                         \
        "SELECT ?1, session_id, vehicle_id, started_at, ended_at, rig, frames_received, frames_tracked, "    \
        "stored_frames, last_durable_sequence, last_delta_version FROM " source                              \
        ".sessions WHERE map_id = ?2",                                                                       \
        "INSERT INTO main.keyframes (map_id, keyframe_id, session_id, sequence, timestamp, parent_id, "      \
        "map_from_camera, keypoint_count, observation_count) "                                               \
        "SELECT ?1, keyframe_id, session_id, sequence, timestamp, parent_id, map_from_camera, "              \
        "keypoint_count, "                                                                                   \
        "observation_count FROM " source                                                                     \
        ".keyframes WHERE map_id = ?2 AND keyframe_id > "                                                    \
        "(SELECT coalesce(max(keyframe_id), 0) FROM main.keyframes WHERE map_id = ?1) ORDER BY keyframe_id " \
        "LIMIT ?3",                                                                                          \
        "INSERT INTO main.keyframe_features (map_id, keyframe_id, part, kept, features) "                    \
        "SELECT ?1, keyframe_id, part, kept, features" SEMMAP_OF_COPIED_KEYFRAMES(source,                    \
                                                                                  "keyframe_features"),      \
        "INSERT INTO main.keyframe_observations (map_id, keyframe_id, observations) "                        \
        "SELECT ?1, keyframe_id, observations" SEMMAP_OF_COPIED_KEYFRAMES(source, "keyframe_observations"),  \
        "INSERT INTO main.keyframe_words (map_id, keyframe_id, vocabulary, words) "                          \
        "SELECT ?1, keyframe_id, vocabulary, words" SEMMAP_OF_COPIED_KEYFRAMES(source, "keyframe_words"),    \
        "INSERT INTO main.keyframe_cells SELECT (?1 << 40) | (id & 1099511627775), 2 * ?1, 2 * ?1 + 1, "     \
        "x_min, x_max, "                                                                                     \
        "y_min, y_max, z_min, z_max FROM " source                                                            \
        ".keyframe_cells WHERE map_min >= 2 * ?2 AND map_max <= 2 * ?2 + 1",                                 \
        "INSERT INTO main.points (point_key, cell_key, session_id, x, y, z, semantic_class, "                \
        "class_confidence, "                                                                                 \
        "observation_count, first_seen, last_seen, reference_keyframe_id, appearance) "                      \
        "SELECT (?1 << 40) | point_id, cell_key, session_id, x, y, z, semantic_class, class_confidence, "    \
        "observation_count, first_seen, last_seen, reference_keyframe_id, appearance FROM " source           \
        ".points "                                                                                           \
        "WHERE point_key > ((?2 << 40) | (?3 & 1099511627775)) AND point_key < (?2 + 1) << 40 ORDER BY "     \
        "point_key "                                                                                         \
        "LIMIT ?4",                                                                                          \
        "INSERT INTO main.frames (map_id, session_id, sequence, timestamp, keyframe_id, "                    \
        "keyframe_from_camera) "                                                                             \
        "SELECT ?1, session_id, sequence, timestamp, keyframe_id, keyframe_from_camera FROM " source         \
        ".frames "                                                                                           \
        "WHERE map_id = ?2 AND (session_id, sequence) > "                                                    \
        "(SELECT session_id, sequence FROM (SELECT session_id, sequence FROM main.frames WHERE map_id = ?1 " \
        "UNION ALL SELECT 0, 0) ORDER BY session_id DESC, sequence DESC LIMIT 1) "                           \
        "ORDER BY session_id, sequence LIMIT ?3",                                                            \
        "UPDATE main.sessions SET name = (SELECT CASE WHEN EXISTS (SELECT 1 FROM main.sessions AS other "    \
        "WHERE "                                                                                             \
        "other.name = original.name) THEN original.name || '-' || ?1 ELSE original.name END "                \
        "FROM " source                                                                                       \
        ".sessions AS original WHERE original.map_id = ?2 AND "                                              \
        "original.session_id = main.sessions.session_id) WHERE map_id = ?1",                                 \
        "UPDATE main.maps SET name = ?3, updated_at = created_at, (keyframe_count, point_count, version, "   \
        "last_keyframe_id, last_point_id, last_session_id) = (SELECT keyframe_count, point_count, version, " \
        "last_keyframe_id, last_point_id, last_session_id FROM " source                                      \
        ".maps WHERE map_id = ?2) WHERE map_id = ?1"                                                         \
  }

constexpr CopyStatements kWithin = SEMMAP_COPY_STATEMENTS("main");
constexpr CopyStatements kFromAttached = SEMMAP_COPY_STATEMENTS("source");
#undef SEMMAP_COPY_STATEMENTS
#undef SEMMAP_OF_COPIED_KEYFRAMES

const CopyStatements& StatementsOf(MapCopy::From from) {
  return from == MapCopy::From::kSameDatabase ? kWithin : kFromAttached;
}

constexpr char kGreatestPoint[] =
    "SELECT coalesce(max(point_key), ?1 << 40) FROM main.points WHERE point_key < (?1 + 1) << 40";
constexpr char kCellsOfCopied[] =
    "SELECT DISTINCT cell_key FROM main.points WHERE point_key > ?2 AND point_key < (?1 + 1) << 40";
constexpr char kSelectSource[] =
    "SELECT version, keyframe_count + point_count FROM source.maps WHERE map_id = ? AND name IS NOT NULL";
constexpr char kSelectSame[] =
    "SELECT version, keyframe_count + point_count FROM main.maps WHERE map_id = ? AND name IS NOT NULL";

struct SourceFacts {
  uint64_t version = 0;
  uint64_t rows = 0;  // keyframes and points
};

absl::StatusOr<SourceFacts> ReadSource(Connection& connection, MapCopy::From from, MapId source) {
  Query select(connection, from == MapCopy::From::kSameDatabase ? kSelectSame : kSelectSource);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Bind(source).Step());
  if (found) return SourceFacts{select.Unsigned(0), select.Unsigned(1)};
  return absl::NotFoundError(absl::StrCat("no map with id ", source.value()));
}

absl::StatusOr<int64_t> Run(Connection& connection, const char* sql, MapId copy, MapId source, int limit) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, sql, copy, source, limit));
  return connection.changes();
}

// The cells of the points that were copied behind `last`.
absl::Status AddCellsBehind(Connection& connection, MapId copy, int64_t last) {
  std::vector<int64_t> cells;
  {
    Query select(connection, kCellsOfCopied);
    select.Bind(copy).Bind(last);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
      if (!row) break;
      cells.push_back(select.Int(0));
    }
  }
  for (const int64_t cell : cells) SEMMAP_RETURN_IF_ERROR(AddPointCell(connection, copy, UnpackCell(cell)));
  return absl::OkStatus();
}

}  // namespace

MapCopy::MapCopy(From from, MapId source, MapId copy, uint64_t version, uint64_t rows)
    : from_(from), source_(source), copy_(copy), version_(version), rows_(rows) {}

absl::StatusOr<MapCopy> MapCopy::Begin(Connection& connection, From from, MapId source,
                                       TimestampNs created_at) {
  SEMMAP_ASSIGN_OR_RETURN(const SourceFacts facts, ReadSource(connection, from, source));
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, StatementsOf(from).insert_map, created_at, source));
  const MapId copy(static_cast<uint64_t>(connection.last_insert_rowid()));
  return MapCopy(from, source, copy, facts.version, facts.rows);
}

absl::StatusOr<int64_t> MapCopy::CopyKeyFrames(Connection& connection) const {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t copied,
                          Run(connection, StatementsOf(from_).keyframes, copy_, source_, kKeyFramesPerStep));
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, StatementsOf(from_).features, copy_, source_));
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, StatementsOf(from_).observations, copy_, source_));
  // A file that comes from elsewhere is not believed what its features look like, and so need not say it.
  if (from_ == From::kSameDatabase)
    SEMMAP_RETURN_IF_ERROR(RunQuery(connection, StatementsOf(from_).words, copy_, source_));
  return copied;
}

absl::StatusOr<int64_t> MapCopy::CopyPoints(Connection& connection) const {
  SEMMAP_ASSIGN_OR_RETURN(int64_t last, QueryInteger(connection, kGreatestPoint, copy_));
  // The greatest point of all maps before this one, when the copy has none yet.
  last = std::max(last, PointKey(copy_, MapPointId()));
  SEMMAP_RETURN_IF_ERROR(
      RunQuery(connection, StatementsOf(from_).points, copy_, source_, last, kPointsPerStep));
  const int64_t copied = connection.changes();
  SEMMAP_RETURN_IF_ERROR(AddCellsBehind(connection, copy_, last));
  return copied;
}

absl::StatusOr<int64_t> MapCopy::CopyOf(Stage stage, Connection& connection) const {
  switch (stage) {
    case Stage::kSessions:
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection, StatementsOf(from_).sessions, copy_, source_));
      return 0;
    case Stage::kKeyFrames:
      return CopyKeyFrames(connection);
    case Stage::kKeyFrameCells:
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection, StatementsOf(from_).keyframe_cells, copy_, source_));
      return 0;
    case Stage::kPoints:
      return CopyPoints(connection);
    case Stage::kFrames:
      return Run(connection, StatementsOf(from_).frames, copy_, source_, kFramesPerStep);
    case Stage::kDone:
      return 0;
  }
  return 0;
}

absl::StatusOr<bool> MapCopy::Step(Connection& connection) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t copied, CopyOf(stage_, connection));
  if (stage_ != Stage::kFrames) done_ += static_cast<uint64_t>(copied);
  if (copied == 0 && stage_ != Stage::kDone) stage_ = static_cast<Stage>(static_cast<int>(stage_) + 1);
  return stage_ == Stage::kDone;
}

double MapCopy::Progress() const {
  if (stage_ == Stage::kDone) return 1;
  return static_cast<double>(done_) / static_cast<double>(rows_ + 1);
}

absl::Status MapCopy::Finish(Connection& connection, std::string_view name) {
  const absl::StatusOr<SourceFacts> source = ReadSource(connection, from_, source_);
  const bool changed = absl::IsNotFound(source.status()) || (source.ok() && source->version != version_);
  if (changed) return absl::AbortedError("the map was changed while it was copied");
  SEMMAP_RETURN_IF_ERROR(source.status());
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, StatementsOf(from_).name_sessions, copy_, source_));
  Query show(connection, StatementsOf(from_).show);
  const absl::Status status = show.Bind(copy_).Bind(source_).BindText(name).Run();
  if (!IsConstraintViolation(status)) return status;
  return absl::AlreadyExistsError(absl::StrCat("map ", std::string(name), " exists"));
}

}  // namespace semmap::storage::sqlite
