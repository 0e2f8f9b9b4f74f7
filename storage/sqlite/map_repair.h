#pragma once

#include "absl/status/status.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// Removes what contradicts itself in a map and counts anew what is counted; runs inside the caller's
// transaction.
//   - keyframes whose pose, features or list of keypoints cannot be decoded go, with the frames that hang on
//   them
//   - points that cannot be decoded, are not finite or are seen by nobody go
//   - observations of missing points, and second ones of the same point, go
//   - parents and reference keyframes that are missing are replaced, cycles of parents cut
//   - counts, greatest ids and the entries of the spatial index are made anew
// What is wrong with the database file itself, or with a map's or session's rig, stays.
absl::Status RepairMapRows(Connection& connection, MapId map);

}  // namespace semmap::storage::sqlite
