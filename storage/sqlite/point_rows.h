#pragma once

#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/byte_buffer.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/query.h"

// The rows of map points and their places in the spatial index. Writers run inside the caller's transaction.
namespace semmap::storage::sqlite {

// Replaces or adds the point; true when it was added. `buffer` is for scratch.
absl::StatusOr<bool> UpsertPoint(Connection& connection, MapId map, SessionId session,
                                 const MapPointRecord& point, ByteWriter* buffer);
// True when there was such a point.
absl::StatusOr<bool> ErasePoint(Connection& connection, MapId map, MapPointId point);
// Removes the points that the session added; returns how many.
absl::StatusOr<int64_t> ErasePointsOf(Connection& connection, MapId map, SessionId session);

absl::Status VisitPoints(Connection& connection, MapId map, const MapPointQuery& query,
                         const MapPointVisitor& visit);
absl::StatusOr<std::vector<MapPointRecord>> ReadPoints(Connection& connection, MapId map,
                                                       std::span<const MapPointId> ids);

// All rows in order of ids, for those that read every point whatever it holds: step `rows` and read each with
// ReadPointRow, which answers DATA_LOSS (with point->id set) for a row that cannot be.
extern const char kSelectAllPoints[];  // bind the map, and 0
absl::Status ReadPointRow(const Query& row, MapPointRecord* point);

}  // namespace semmap::storage::sqlite
