#pragma once

#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// The rows of maps. Writers run inside the caller's transaction.
namespace semmap::storage::sqlite {

absl::StatusOr<MapId> InsertMap(Connection& connection, const NewMap& map);
absl::StatusOr<MapInfo> ReadMap(Connection& connection, std::string_view name);
absl::StatusOr<MapInfo> ReadMap(Connection& connection, MapId map);
absl::StatusOr<std::vector<MapInfo>> ReadMaps(Connection& connection, const MapListQuery& query);
// NOT_FOUND unless the map exists and is not being deleted.
absl::Status RequireMap(Connection& connection, MapId map);
// NOT_FOUND, ALREADY_EXISTS.
absl::Status UpdateName(Connection& connection, MapId map, std::string_view name);
// NOT_FOUND, ABORTED.
absl::Status UpdateDescription(Connection& connection, MapId map, const MapChanges& changes);

// Where the map's points are indexed.
struct MapPlacement {
  double cell_size = 0;  // 0 until the map gets its first points
  MapPointId last_point_id;
};
absl::StatusOr<MapPlacement> ReadPlacement(Connection& connection, MapId map);
absl::Status SetCellSize(Connection& connection, MapId map, double cell_size);

// What a delta did to the map as a whole.
struct MapGrowth {
  int64_t keyframes = 0;
  int64_t points = 0;
  KeyFrameId last_keyframe_id;
  MapPointId last_point_id;
  // Frames of a trajectory alone leave the map as it is.
  bool changes_map = true;
};
absl::Status UpdateGrowth(Connection& connection, MapId map, const MapGrowth& growth);

// Deleting, in steps: first the map is gone for everybody, then its rows go bit by bit.
absl::Status HideMap(Connection& connection, MapId map);
// Removes a bounded number of rows of a hidden map; true when nothing is left of it.
absl::StatusOr<bool> PurgeStep(Connection& connection, MapId map);
absl::StatusOr<std::vector<MapId>> HiddenMaps(Connection& connection);

}  // namespace semmap::storage::sqlite
