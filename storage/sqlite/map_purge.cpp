// The part of map_rows.h that deletes maps.
#include "slam/common/status_macros.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/spatial_index.h"

namespace semmap::storage::sqlite {
namespace {

// Rows of a step: small enough that a vehicle's delta does not wait long for the lock.
constexpr int kFramesPerStep = 5000;
constexpr int kPointsPerStep = 5000;
constexpr int kCellsPerStep = 1000;
constexpr int kKeyFramesPerStep = 50;

constexpr char kHideMap[] = "UPDATE maps SET name = NULL WHERE map_id = ?";
constexpr char kHideSessions[] = "UPDATE sessions SET name = NULL WHERE map_id = ?";
constexpr char kSelectHidden[] = "SELECT map_id FROM maps WHERE name IS NULL";
constexpr char kDeleteFrames[] =
    "DELETE FROM frames WHERE map_id = ?1 AND (session_id, sequence) IN "
    "(SELECT session_id, sequence FROM frames WHERE map_id = ?1 ORDER BY session_id, sequence LIMIT ?2)";
constexpr char kDeletePoints[] =
    "DELETE FROM points WHERE point_key IN "
    "(SELECT point_key FROM points WHERE point_key > ? AND point_key < ? ORDER BY point_key LIMIT ?)";
constexpr char kSelectKeyFrames[] =
    "SELECT keyframe_id FROM keyframes WHERE map_id = ? ORDER BY keyframe_id LIMIT ?";
constexpr char kDeleteKeyFrames[] = "DELETE FROM keyframes WHERE map_id = ? AND keyframe_id <= ?";
constexpr char kDeleteSessions[] = "DELETE FROM sessions WHERE map_id = ?";
constexpr char kDeleteMap[] = "DELETE FROM maps WHERE map_id = ?";

absl::Status PurgePoints(Connection& connection, MapId map) {
  Query remove(connection, kDeletePoints);
  BindPointsBehind(remove, map, MapPointId());
  return remove.Bind(kPointsPerStep).Run();
}

// Removes keyframes with their places in the index; true when none were left.
absl::StatusOr<bool> PurgeKeyFrames(Connection& connection, MapId map) {
  KeyFrameId last;
  {
    Query ids(connection, kSelectKeyFrames);
    ids.Bind(map).Bind(kKeyFramesPerStep);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, ids.Step());
      if (!row) break;
      last = ids.IdAt<KeyFrameId>(0);
      SEMMAP_RETURN_IF_ERROR(EraseKeyFrameCell(connection, map, last));
    }
  }
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kDeleteKeyFrames, map, last));
  return !last.IsValid();
}

}  // namespace

absl::Status HideMap(Connection& connection, MapId map) {
  SEMMAP_RETURN_IF_ERROR(RequireMap(connection, map));
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kHideMap, map));
  return RunQuery(connection, kHideSessions, map);
}

absl::StatusOr<bool> PurgeStep(Connection& connection, MapId map) {
  // It was being made, by another process, and is shown now.
  if (RequireMap(connection, map).ok()) return true;
  // What refers to others goes before them.
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kDeleteFrames, map, kFramesPerStep));
  if (connection.changes() > 0) return false;
  SEMMAP_RETURN_IF_ERROR(PurgePoints(connection, map));
  if (connection.changes() > 0) return false;
  SEMMAP_ASSIGN_OR_RETURN(const bool no_cells, ErasePointCells(connection, map, kCellsPerStep));
  if (!no_cells) return false;
  SEMMAP_ASSIGN_OR_RETURN(const bool no_keyframes, PurgeKeyFrames(connection, map));
  if (!no_keyframes) return false;
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kDeleteSessions, map));
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kDeleteMap, map));
  return true;
}

absl::StatusOr<std::vector<MapId>> HiddenMaps(Connection& connection) {
  Query select(connection, kSelectHidden);
  std::vector<MapId> maps;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) return maps;
    maps.push_back(select.IdAt<MapId>(0));
  }
}

}  // namespace semmap::storage::sqlite
