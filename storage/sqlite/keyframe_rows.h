#pragma once

#include <span>

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/feature_rows.h"
#include "storage/sqlite/query.h"

// The rows of keyframes with their features, observations and places in the spatial index. Writers run inside
// the caller's transaction and answer INVALID_ARGUMENT for a keyframe that should exist and does not, or the
// reverse. Of a new keyframe's keypoints at most writing->max_keypoints are stored, those that see a point
// (`point_of_keypoint`, empty when it is not told) first.
namespace semmap::storage::sqlite {

absl::Status InsertKeyFrame(Connection& connection, MapId map, SessionId session,
                            const KeyFrameRecord& keyframe, std::span<const MapPointId> point_of_keypoint,
                            FeatureWriting* writing);
absl::Status MoveKeyFrame(Connection& connection, MapId map, const KeyFramePose& moved);
// Stores keypoints that see a point for the first time and were left out before.
absl::Status WriteObservations(Connection& connection, MapId map, const KeyFrameObservations& observations,
                               FeatureWriting* writing);
// Frames are re-anchored, children get another parent, then the keyframe goes.
absl::Status RemoveKeyFrame(Connection& connection, MapId map, const RemovedKeyFrame& removal);
// Removes the keyframes that the session added; returns how many.
absl::StatusOr<int64_t> EraseKeyFramesOf(Connection& connection, MapId map, SessionId session);

absl::Status VisitKeyFrames(Connection& connection, MapId map, const KeyFrameQuery& query,
                            const KeyFrameVisitor& visit);
absl::StatusOr<KeyFrameEntry> ReadKeyFrame(Connection& connection, MapId map, KeyFrameId keyframe);
absl::StatusOr<KeyFrameObservations> ReadObservations(Connection& connection, MapId map, KeyFrameId keyframe);

}  // namespace semmap::storage::sqlite
