#pragma once

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// The rows of vehicle frames. Writers run inside the caller's transaction.
namespace semmap::storage::sqlite {

// True when it was added, false when it replaced an earlier pose. INVALID_ARGUMENT when its keyframe does not
// exist.
absl::StatusOr<bool> UpsertFrame(Connection& connection, MapId map, SessionId session,
                                 const FramePose& frame);
// Frames of the removed keyframe become relative to its heir.
absl::Status ReanchorFrames(Connection& connection, MapId map, const RemovedKeyFrame& removal);
// Frames keep their distance to the keyframe in its new unit.
absl::Status RescaleFrames(Connection& connection, MapId map, const KeyFramePose& moved);
absl::Status EraseFramesOf(Connection& connection, MapId map, SessionId session);

absl::Status VisitTrajectory(Connection& connection, MapId map, const TrajectoryQuery& query,
                             const TrajectoryVisitor& visit);

}  // namespace semmap::storage::sqlite
