#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "storage/byte_buffer.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// How far the ids of a map move when it is joined to another one.
struct JoinedIds {
  uint64_t keyframes = 0;
  uint64_t points = 0;
  uint64_t sessions = 0;
};

// Adds the contents of one map to a hidden one in bounded steps, each a transaction of the caller's. Sessions
// stay without names. Points are in no cell until the changes of the rewrite put them in theirs.
class JoinedCopy {
 public:
  // With `forget_depth` keypoints lose their depths, for a map of one eye.
  JoinedCopy(MapId from, MapId to, const JoinedIds& ids, bool forget_depth)
      : from_(from), to_(to), ids_(ids), forget_depth_(forget_depth) {}

  // True when all is copied.
  absl::StatusOr<bool> Step(Connection& connection);

 private:
  enum class Stage { kSessions, kKeyFrames, kKeyFrameCells, kPoints, kFrames, kDone };

  absl::StatusOr<int64_t> StepOf(Stage stage, Connection& connection);
  absl::StatusOr<int64_t> CopyKeyFrames(Connection& connection);
  absl::Status CopyFeatures(Connection& connection, KeyFrameId keyframe);
  absl::Status CopyObservations(Connection& connection, KeyFrameId keyframe);
  absl::StatusOr<int64_t> CopyPoints(Connection& connection);
  absl::StatusOr<int64_t> CopyFrames(Connection& connection);

  MapId from_;
  MapId to_;
  JoinedIds ids_;
  bool forget_depth_;
  Stage stage_ = Stage::kSessions;
  // What was copied last, by its ids in the source.
  KeyFrameId last_keyframe_;
  MapPointId last_point_;
  SessionId last_session_;
  int64_t last_sequence_ = -1;
  ByteWriter buffer_;
};

}  // namespace semmap::storage::sqlite
