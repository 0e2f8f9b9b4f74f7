#include "storage/sqlite/joined_copy.h"

#include <numeric>
#include <utility>
#include <vector>

#include "slam/common/status_macros.h"
#include "storage/feature_codec.h"
#include "storage/joined_map_loader.h"
#include "storage/observation_codec.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"

namespace semmap::storage::sqlite {
namespace {

// As for copies: a vehicle's delta does not wait long for the lock.
constexpr int kKeyFramesPerStep = 50;
constexpr int kPointsPerStep = 5000;
constexpr int kFramesPerStep = 5000;

// ?1 is the hidden map, ?2 the one that is joined everywhere.
constexpr char kSessions[] =
    "INSERT INTO sessions (map_id, session_id, vehicle_id, started_at, ended_at, rig, frames_received, "
    "frames_tracked, stored_frames, last_durable_sequence, last_delta_version) "
    "SELECT ?1, session_id + ?3, vehicle_id, started_at, ended_at, rig, frames_received, frames_tracked, "
    "stored_frames, last_durable_sequence, last_delta_version FROM sessions WHERE map_id = ?2";
constexpr char kSelectKeyFrames[] =
    "SELECT keyframe_id FROM keyframes WHERE map_id = ? AND keyframe_id > ? ORDER BY keyframe_id LIMIT ?";
constexpr char kKeyFrame[] =
    "INSERT INTO keyframes (map_id, keyframe_id, session_id, sequence, timestamp, parent_id, "
    "map_from_camera, keypoint_count, observation_count) "
    "SELECT ?1, keyframe_id + ?4, session_id + ?5, sequence, timestamp, parent_id + ?4, map_from_camera, "
    "keypoint_count, observation_count FROM keyframes WHERE map_id = ?2 AND keyframe_id = ?3";
constexpr char kFeatures[] =
    "INSERT INTO keyframe_features (map_id, keyframe_id, part, kept, features) "
    "SELECT ?1, keyframe_id + ?4, part, kept, features FROM keyframe_features "
    "WHERE map_id = ?2 AND keyframe_id = ?3";
constexpr char kSelectFeatures[] =
    "SELECT part, features FROM keyframe_features WHERE map_id = ? AND keyframe_id = ?";
constexpr char kUpdateFeatures[] =
    "UPDATE keyframe_features SET features = ? WHERE map_id = ? AND keyframe_id = ? AND part = ?";
constexpr char kSelectObservations[] =
    "SELECT observations FROM keyframe_observations WHERE map_id = ? AND keyframe_id = ?";
constexpr char kInsertObservations[] =
    "INSERT INTO keyframe_observations (map_id, keyframe_id, observations) VALUES (?, ?, ?)";
constexpr char kKeyFrameCells[] =
    "INSERT INTO keyframe_cells SELECT (?1 << 40) | ((id & 1099511627775) + ?3), 2 * ?1, 2 * ?1 + 1, x_min, "
    "x_max, y_min, y_max, z_min, z_max FROM keyframe_cells WHERE map_min >= 2 * ?2 AND map_max <= 2 * ?2 + 1";
// No cell has key -1.
constexpr char kPoints[] =
    "INSERT INTO points (point_key, cell_key, session_id, x, y, z, semantic_class, class_confidence, "
    "observation_count, first_seen, last_seen, reference_keyframe_id, appearance) "
    "SELECT (?1 << 40) | (point_id + ?3), -1, session_id + ?4, x, y, z, semantic_class, class_confidence, "
    "observation_count, first_seen, last_seen, reference_keyframe_id + ?5, appearance FROM points "
    "WHERE point_key > ((?2 << 40) | ?6) AND point_key < (?2 + 1) << 40 ORDER BY point_key LIMIT ?7";
constexpr char kGreatestPoint[] =
    "SELECT max(point_key) & 1099511627775 FROM points WHERE point_key < (?1 + 1) << 40";
constexpr char kFrames[] =
    "INSERT INTO frames (map_id, session_id, sequence, timestamp, keyframe_id, keyframe_from_camera) "
    "SELECT ?1, session_id + ?3, sequence, timestamp, keyframe_id + ?4, keyframe_from_camera FROM frames "
    "WHERE map_id = ?2 AND (session_id, sequence) > (?5, ?6) ORDER BY session_id, sequence LIMIT ?7";
constexpr char kLastFrame[] =
    "SELECT session_id, sequence FROM frames WHERE map_id = ? ORDER BY session_id DESC, sequence DESC LIMIT "
    "1";

}  // namespace

absl::Status JoinedCopy::CopyFeatures(Connection& connection, KeyFrameId keyframe) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kFeatures, to_, from_, keyframe, ids_.keyframes));
  if (!forget_depth_) return absl::OkStatus();
  std::vector<std::pair<int64_t, FrameFeatures>> parts;
  {
    Query select(connection, kSelectFeatures);
    select.Bind(from_).Bind(keyframe);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
      if (!row) break;
      SEMMAP_ASSIGN_OR_RETURN(FrameFeatures features, DecodeFeatures(select.Bytes(1)));
      parts.emplace_back(select.Int(0), WithoutDepth(std::move(features)));
    }
  }
  for (const auto& [part, features] : parts) {
    std::vector<uint32_t> all(features.size());
    std::iota(all.begin(), all.end(), 0U);
    EncodeFeatures(features, all, &buffer_);
    Query update(connection, kUpdateFeatures);
    update.BindBlob(buffer_.view()).Bind(to_).Bind(keyframe.value() + ids_.keyframes).Bind(part);
    SEMMAP_RETURN_IF_ERROR(update.Run());
  }
  return absl::OkStatus();
}

absl::Status JoinedCopy::CopyObservations(Connection& connection, KeyFrameId keyframe) {
  std::vector<MapPointId> points;
  {
    Query select(connection, kSelectObservations);
    select.Bind(from_).Bind(keyframe);
    SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
    if (!found) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(points, DecodeObservations(select.Bytes(0)));
  }
  for (MapPointId& point : points) {
    if (point.IsValid()) point = MapPointId(point.value() + ids_.points);
  }
  EncodeObservations(points, &buffer_);
  Query insert(connection, kInsertObservations);
  return insert.Bind(to_).Bind(keyframe.value() + ids_.keyframes).BindBlob(buffer_.view()).Run();
}

absl::StatusOr<int64_t> JoinedCopy::CopyKeyFrames(Connection& connection) {
  std::vector<KeyFrameId> ids;
  {
    Query select(connection, kSelectKeyFrames);
    select.Bind(from_).Bind(last_keyframe_).Bind(kKeyFramesPerStep);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
      if (!row) break;
      ids.push_back(select.IdAt<KeyFrameId>(0));
    }
  }
  for (const KeyFrameId id : ids) {
    SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kKeyFrame, to_, from_, id, ids_.keyframes, ids_.sessions));
    SEMMAP_RETURN_IF_ERROR(CopyFeatures(connection, id));
    SEMMAP_RETURN_IF_ERROR(CopyObservations(connection, id));
    last_keyframe_ = id;
  }
  return static_cast<int64_t>(ids.size());
}

absl::StatusOr<int64_t> JoinedCopy::CopyPoints(Connection& connection) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kPoints, to_, from_, ids_.points, ids_.sessions, ids_.keyframes,
                                  last_point_, kPointsPerStep));
  const int64_t copied = connection.changes();
  if (copied > 0) {
    SEMMAP_ASSIGN_OR_RETURN(const int64_t greatest, QueryInteger(connection, kGreatestPoint, to_));
    last_point_ = MapPointId(static_cast<uint64_t>(greatest) - ids_.points);
  }
  return copied;
}

absl::StatusOr<int64_t> JoinedCopy::CopyFrames(Connection& connection) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kFrames, to_, from_, ids_.sessions, ids_.keyframes,
                                  last_session_, last_sequence_, kFramesPerStep));
  const int64_t copied = connection.changes();
  if (copied > 0) {
    Query last(connection, kLastFrame);
    SEMMAP_RETURN_IF_ERROR(last.Bind(to_).Step().status());
    last_session_ = SessionId(last.Unsigned(0) - ids_.sessions);
    last_sequence_ = last.Int(1);
  }
  return copied;
}

absl::StatusOr<int64_t> JoinedCopy::StepOf(Stage stage, Connection& connection) {
  switch (stage) {
    case Stage::kSessions:
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kSessions, to_, from_, ids_.sessions));
      return 0;
    case Stage::kKeyFrames:
      return CopyKeyFrames(connection);
    case Stage::kKeyFrameCells:
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kKeyFrameCells, to_, from_, ids_.keyframes));
      return 0;
    case Stage::kPoints:
      return CopyPoints(connection);
    case Stage::kFrames:
      return CopyFrames(connection);
    case Stage::kDone:
      return 0;
  }
  return 0;
}

absl::StatusOr<bool> JoinedCopy::Step(Connection& connection) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t copied, StepOf(stage_, connection));
  if (copied == 0 && stage_ != Stage::kDone) stage_ = static_cast<Stage>(static_cast<int>(stage_) + 1);
  return stage_ == Stage::kDone;
}

}  // namespace semmap::storage::sqlite
