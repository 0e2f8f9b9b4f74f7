#include "storage/sqlite/frame_rows.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/geometry_codec.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kInsert[] =
    "INSERT INTO frames (timestamp, keyframe_id, keyframe_from_camera, map_id, session_id, sequence) "
    "VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (map_id, session_id, sequence) DO NOTHING";
constexpr char kUpdate[] =
    "UPDATE frames SET timestamp = ?, keyframe_id = ?, keyframe_from_camera = ? "
    "WHERE map_id = ? AND session_id = ? AND sequence = ?";
constexpr char kSelectOfKeyFrame[] =
    "SELECT session_id, sequence, timestamp, keyframe_from_camera FROM frames WHERE map_id = ? AND "
    "keyframe_id = ?";
constexpr char kDeleteOfSession[] = "DELETE FROM frames WHERE map_id = ? AND session_id = ?";
#define SEMMAP_SELECT_POSES                                                                                 \
  "SELECT f.session_id, f.sequence, f.timestamp, f.keyframe_id, f.keyframe_from_camera, k.map_from_camera " \
  "FROM frames f JOIN keyframes k ON k.map_id = f.map_id AND k.keyframe_id = f.keyframe_id "
constexpr char kSelectAll[] = SEMMAP_SELECT_POSES
    "WHERE f.map_id = ? AND (f.session_id, f.sequence) > (?, ?) ORDER BY f.session_id, f.sequence";
constexpr char kSelectOfSession[] =
    SEMMAP_SELECT_POSES "WHERE f.map_id = ? AND f.session_id = ? AND f.sequence > ? ORDER BY f.sequence";
#undef SEMMAP_SELECT_POSES

struct SessionFrame {
  SessionId session;
  FramePose frame;
};

absl::Status Write(Connection& connection, const char* sql, MapId map, SessionId session,
                   const FramePose& frame) {
  const auto pose = EncodePose(frame.keyframe_from_camera);
  Query query(connection, sql);
  query.Bind(frame.timestamp).Bind(frame.reference_keyframe).BindBlob(pose);
  const absl::Status status = query.Bind(map).Bind(session).Bind(frame.sequence).Run();
  if (!IsConstraintViolation(status)) return status;
  return absl::InvalidArgumentError(absl::StrCat("frame ", frame.sequence, ": keyframe ",
                                                 frame.reference_keyframe.value(), " does not exist"));
}

absl::StatusOr<std::vector<SessionFrame>> FramesOf(Connection& connection, MapId map, KeyFrameId keyframe) {
  Query select(connection, kSelectOfKeyFrame);
  select.Bind(map).Bind(keyframe);
  std::vector<SessionFrame> frames;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) return frames;
    SEMMAP_ASSIGN_OR_RETURN(const SE3 pose, DecodePose(select.Bytes(3)));
    frames.push_back({select.IdAt<SessionId>(0), {select.Unsigned(1), select.Int(2), keyframe, pose}});
  }
}

absl::StatusOr<TrajectoryPose> ReadRow(const Query& row) {
  TrajectoryPose pose;
  pose.session = row.IdAt<SessionId>(0);
  pose.sequence = row.Unsigned(1);
  pose.timestamp = row.Int(2);
  pose.reference_keyframe = row.IdAt<KeyFrameId>(3);
  SEMMAP_ASSIGN_OR_RETURN(const SE3 keyframe_from_camera, DecodePose(row.Bytes(4)));
  SEMMAP_ASSIGN_OR_RETURN(const SE3 map_from_keyframe, DecodePose(row.Bytes(5)));
  pose.map_from_camera = map_from_keyframe * keyframe_from_camera;
  return pose;
}

// Where to go on, as what a row must exceed. Sequences begin at 0.
void BindStart(MapId map, const TrajectoryQuery& query, Query* rows) {
  rows->Bind(map);
  if (query.session.has_value()) {
    const bool inside = query.after.has_value() && query.after->session == *query.session;
    rows->Bind(*query.session).Bind(inside ? static_cast<int64_t>(query.after->sequence) : -1);
  } else if (query.after.has_value()) {
    rows->Bind(query.after->session).Bind(query.after->sequence);
  } else {
    rows->Bind(-1).Bind(-1);
  }
}

}  // namespace

absl::StatusOr<bool> UpsertFrame(Connection& connection, MapId map, SessionId session,
                                 const FramePose& frame) {
  SEMMAP_RETURN_IF_ERROR(Write(connection, kInsert, map, session, frame));
  if (connection.changes() > 0) return true;
  SEMMAP_RETURN_IF_ERROR(Write(connection, kUpdate, map, session, frame));
  return false;
}

absl::Status ReanchorFrames(Connection& connection, MapId map, const RemovedKeyFrame& removal) {
  SEMMAP_ASSIGN_OR_RETURN(std::vector<SessionFrame> frames, FramesOf(connection, map, removal.removed));
  for (SessionFrame& frame : frames) {
    frame.frame.reference_keyframe = removal.heir;
    frame.frame.keyframe_from_camera = removal.heir_from_removed * frame.frame.keyframe_from_camera;
    SEMMAP_RETURN_IF_ERROR(Write(connection, kUpdate, map, frame.session, frame.frame));
  }
  return absl::OkStatus();
}

absl::Status RescaleFrames(Connection& connection, MapId map, const KeyFramePose& moved) {
  SEMMAP_ASSIGN_OR_RETURN(std::vector<SessionFrame> frames, FramesOf(connection, map, moved.id));
  for (SessionFrame& frame : frames) {
    SE3& pose = frame.frame.keyframe_from_camera;
    pose = SE3::FromUnitQuaternion(pose.rotation(), moved.rescale * pose.translation());
    SEMMAP_RETURN_IF_ERROR(Write(connection, kUpdate, map, frame.session, frame.frame));
  }
  return absl::OkStatus();
}

absl::Status EraseFramesOf(Connection& connection, MapId map, SessionId session) {
  return RunQuery(connection, kDeleteOfSession, map, session);
}

absl::Status VisitTrajectory(Connection& connection, MapId map, const TrajectoryQuery& query,
                             const TrajectoryVisitor& visit) {
  Query rows(connection, query.session.has_value() ? kSelectOfSession : kSelectAll);
  BindStart(map, query, &rows);
  size_t delivered = 0;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
    if (!row) return absl::OkStatus();
    const TimestampNs timestamp = rows.Int(2);
    if (query.time.has_value() && (timestamp < query.time->begin || timestamp >= query.time->end)) continue;
    SEMMAP_ASSIGN_OR_RETURN(const TrajectoryPose pose, ReadRow(rows));
    if (!visit(pose) || ++delivered == query.limit) return absl::OkStatus();
  }
}

}  // namespace semmap::storage::sqlite
