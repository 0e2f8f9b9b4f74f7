#pragma once

#include "absl/status/statusor.h"
#include "storage/byte_buffer.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/query.h"

// The rows of keyframes with their features, observations and places in the spatial index. Writers run inside
// the caller's transaction and answer INVALID_ARGUMENT for a keyframe that should exist and does not, or the
// reverse. `buffer` is for scratch.
namespace semmap::storage::sqlite {

absl::Status InsertKeyFrame(Connection& connection, MapId map, SessionId session,
                            const KeyFrameRecord& keyframe, ByteWriter* buffer);
absl::Status MoveKeyFrame(Connection& connection, MapId map, const KeyFramePose& moved);
absl::Status WriteObservations(Connection& connection, MapId map, const KeyFrameObservations& observations,
                               ByteWriter* buffer);
// Frames are re-anchored, children get another parent, then the keyframe goes.
absl::Status RemoveKeyFrame(Connection& connection, MapId map, const RemovedKeyFrame& removal);
// Removes the keyframes that the session added; returns how many.
absl::StatusOr<int64_t> EraseKeyFramesOf(Connection& connection, MapId map, SessionId session);

absl::Status VisitKeyFrames(Connection& connection, MapId map, const KeyFrameQuery& query,
                            const KeyFrameVisitor& visit);
absl::StatusOr<KeyFrameEntry> ReadKeyFrame(Connection& connection, MapId map, KeyFrameId keyframe);
absl::StatusOr<KeyFrameObservations> ReadObservations(Connection& connection, MapId map, KeyFrameId keyframe);

}  // namespace semmap::storage::sqlite
