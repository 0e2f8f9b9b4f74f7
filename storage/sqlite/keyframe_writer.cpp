// The part of keyframe_rows.h that writes.
#include <algorithm>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/geometry_codec.h"
#include "storage/observation_codec.h"
#include "storage/sqlite/feature_rows.h"
#include "storage/sqlite/frame_rows.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/spatial_index.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kInsert[] =
    "INSERT INTO keyframes (map_id, keyframe_id, session_id, sequence, timestamp, parent_id, "
    "map_from_camera, "
    "keypoint_count) VALUES (?, ?, ?, ?, ?, ?, ?, ?)";
constexpr char kSelectPose[] = "SELECT map_from_camera FROM keyframes WHERE map_id = ? AND keyframe_id = ?";
constexpr char kUpdatePose[] =
    "UPDATE keyframes SET map_from_camera = ?, parent_id = ? WHERE map_id = ? AND keyframe_id = ?";
constexpr char kSelectKeypointCount[] =
    "SELECT keypoint_count FROM keyframes WHERE map_id = ? AND keyframe_id = ?";
constexpr char kUpdateObservationCount[] =
    "UPDATE keyframes SET observation_count = ? WHERE map_id = ? AND keyframe_id = ?";
constexpr char kUpsertObservations[] =
    "INSERT INTO keyframe_observations (map_id, keyframe_id, observations) VALUES (?, ?, ?) "
    "ON CONFLICT (map_id, keyframe_id) DO UPDATE SET observations = excluded.observations";
constexpr char kSelectParent[] =
    "SELECT coalesce(parent_id, 0) FROM keyframes WHERE map_id = ? AND keyframe_id = ?";
constexpr char kHandChildrenToHeir[] =
    "UPDATE keyframes SET parent_id = ?1 WHERE map_id = ?2 AND parent_id = ?3 AND keyframe_id <> ?1";
constexpr char kHandHeirToGrandparent[] =
    "UPDATE keyframes SET parent_id = nullif(?, 0) WHERE map_id = ? AND parent_id = ? AND keyframe_id = ?";
constexpr char kDelete[] = "DELETE FROM keyframes WHERE map_id = ? AND keyframe_id = ?";
constexpr char kSelectOfSession[] = "SELECT keyframe_id FROM keyframes WHERE map_id = ? AND session_id = ?";
constexpr char kDeleteOfSession[] = "DELETE FROM keyframes WHERE map_id = ? AND session_id = ?";

absl::Status NoSuchKeyFrame(const char* role, KeyFrameId id) {
  return absl::InvalidArgumentError(absl::StrCat(role, " keyframe ", id.value(), " does not exist"));
}

Query& BindParent(Query& query, KeyFrameId parent) {
  return parent.IsValid() ? query.Bind(parent) : query.BindNull();
}

absl::Status InsertRow(Connection& connection, MapId map, SessionId session, const KeyFrameRecord& keyframe) {
  const auto pose = EncodePose(keyframe.map_from_camera);
  Query insert(connection, kInsert);
  insert.Bind(map).Bind(keyframe.id).Bind(session).Bind(keyframe.sequence).Bind(keyframe.timestamp);
  const absl::Status status =
      BindParent(insert, keyframe.parent).BindBlob(pose).Bind(keyframe.features->size()).Run();
  if (!IsConstraintViolation(status)) return status;
  return absl::InvalidArgumentError(absl::StrCat("added keyframe ", keyframe.id.value(), " exists already"));
}

// The parent of a keyframe; NOT_FOUND when there is no such keyframe.
absl::StatusOr<KeyFrameId> ReadParent(Connection& connection, MapId map, KeyFrameId keyframe) {
  Query select(connection, kSelectParent);
  select.Bind(map).Bind(keyframe);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return absl::NotFoundError("no such keyframe");
  return select.IdAt<KeyFrameId>(0);
}

absl::Status HandOverChildren(Connection& connection, MapId map, const RemovedKeyFrame& removal,
                              KeyFrameId grandparent) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kHandChildrenToHeir, removal.heir, map, removal.removed));
  return RunQuery(connection, kHandHeirToGrandparent, grandparent, map, removal.removed, removal.heir);
}

// --- Observations

absl::Status Misfit(const KeyFrameObservations& observations, const char* why) {
  return absl::InvalidArgumentError(
      absl::StrCat("observations of keyframe ", observations.id.value(), ": ", why));
}

absl::StatusOr<size_t> ReadKeypointCount(Connection& connection, MapId map,
                                         const KeyFrameObservations& observations) {
  Query select(connection, kSelectKeypointCount);
  select.Bind(map).Bind(observations.id);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return Misfit(observations, "no such keyframe");
  return static_cast<size_t>(select.Unsigned(0));
}

// Which keypoint of the frame each observation goes through: those who made the keyframe number all keypoints
// of the frame, those who loaded it only the stored ones.
absl::StatusOr<std::vector<uint32_t>> FrameIndices(const KeyFrameObservations& observations,
                                                   size_t keypoint_count, const std::vector<uint32_t>& kept) {
  const size_t count = observations.point_of_keypoint.size();
  const FrameFeatures* features = observations.features.get();
  if (features != nullptr && features->size() != count) {
    return Misfit(observations, "not as many as the keypoints they come with");
  }
  if (features != nullptr && !features->frame_index.empty()) {
    const std::vector<uint32_t>& indices = features->frame_index;
    const bool fits = indices.size() == count && std::is_sorted(indices.begin(), indices.end()) &&
                      (count == 0 || indices.back() < keypoint_count);
    if (fits) return indices;
  } else if (count == keypoint_count) {
    std::vector<uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0U);
    return all;
  } else if (count == kept.size()) {
    return kept;
  }
  return Misfit(observations, "not as many as the keyframe has keypoints");
}

// Stores the keypoints that see a point and were left out so far.
absl::Status StoreNewlySeen(Connection& connection, MapId map, const KeyFrameObservations& observations,
                            const std::vector<uint32_t>& frame_index, const std::vector<uint32_t>& kept,
                            size_t keypoint_count, FeatureWriting* writing) {
  std::vector<uint32_t> positions;
  std::vector<uint32_t> indices;
  for (uint32_t i = 0; i < frame_index.size(); ++i) {
    if (!observations.point_of_keypoint[i].IsValid()) continue;
    if (std::binary_search(kept.begin(), kept.end(), frame_index[i])) continue;
    positions.push_back(i);
    indices.push_back(frame_index[i]);
  }
  if (indices.empty()) return absl::OkStatus();
  if (observations.features == nullptr) {
    return Misfit(observations,
                  "a point is seen through a keypoint that is not stored, and no features come along");
  }
  return AddFeatures(connection, map, observations.id, *observations.features, positions, indices,
                     keypoint_count, writing);
}

}  // namespace

absl::Status InsertKeyFrame(Connection& connection, MapId map, SessionId session,
                            const KeyFrameRecord& keyframe, std::span<const MapPointId> point_of_keypoint,
                            FeatureWriting* writing) {
  SEMMAP_RETURN_IF_ERROR(InsertRow(connection, map, session, keyframe));
  SEMMAP_RETURN_IF_ERROR(InsertFeatures(connection, map, keyframe, point_of_keypoint, writing));
  return PutKeyFrameCell(connection, map, keyframe.id,
                         CellOf(keyframe.map_from_camera.translation(), kKeyFrameCell));
}

absl::Status MoveKeyFrame(Connection& connection, MapId map, const KeyFramePose& moved) {
  const Cell cell = CellOf(moved.map_from_camera.translation(), kKeyFrameCell);
  bool same_cell = false;
  {
    Query select(connection, kSelectPose);
    select.Bind(map).Bind(moved.id);
    SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
    if (!found) return NoSuchKeyFrame("moved", moved.id);
    SEMMAP_ASSIGN_OR_RETURN(const SE3 old_pose, DecodePose(select.Bytes(0)));
    same_cell = CellOf(old_pose.translation(), kKeyFrameCell) == cell;
  }
  const auto pose = EncodePose(moved.map_from_camera);
  Query update(connection, kUpdatePose);
  update.BindBlob(pose);
  SEMMAP_RETURN_IF_ERROR(BindParent(update, moved.parent).Bind(map).Bind(moved.id).Run());
  return same_cell ? absl::OkStatus() : PutKeyFrameCell(connection, map, moved.id, cell);
}

absl::Status WriteObservations(Connection& connection, MapId map, const KeyFrameObservations& observations,
                               FeatureWriting* writing) {
  SEMMAP_ASSIGN_OR_RETURN(const size_t keypoint_count, ReadKeypointCount(connection, map, observations));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<uint32_t> kept,
                          ReadKeptKeypoints(connection, map, observations.id, keypoint_count));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<uint32_t> frame_index,
                          FrameIndices(observations, keypoint_count, kept));
  SEMMAP_RETURN_IF_ERROR(
      StoreNewlySeen(connection, map, observations, frame_index, kept, keypoint_count, writing));
  std::vector<MapPointId> point_of_keypoint(keypoint_count);
  for (size_t i = 0; i < frame_index.size(); ++i) {
    point_of_keypoint[frame_index[i]] = observations.point_of_keypoint[i];
  }
  const uint32_t count = EncodeObservations(point_of_keypoint, &writing->buffer);
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kUpdateObservationCount, count, map, observations.id));
  Query upsert(connection, kUpsertObservations);
  return upsert.Bind(map).Bind(observations.id).BindBlob(writing->buffer.view()).Run();
}

absl::Status RemoveKeyFrame(Connection& connection, MapId map, const RemovedKeyFrame& removal) {
  const absl::StatusOr<KeyFrameId> parent = ReadParent(connection, map, removal.removed);
  if (absl::IsNotFound(parent.status())) return NoSuchKeyFrame("removed", removal.removed);
  SEMMAP_RETURN_IF_ERROR(parent.status());
  const absl::StatusOr<KeyFrameId> heir_parent = ReadParent(connection, map, removal.heir);
  if (absl::IsNotFound(heir_parent.status())) return NoSuchKeyFrame("heir", removal.heir);
  SEMMAP_RETURN_IF_ERROR(heir_parent.status());
  SEMMAP_RETURN_IF_ERROR(ReanchorFrames(connection, map, removal));
  SEMMAP_RETURN_IF_ERROR(HandOverChildren(connection, map, removal, *parent));
  SEMMAP_RETURN_IF_ERROR(EraseKeyFrameCell(connection, map, removal.removed));
  return RunQuery(connection, kDelete, map, removal.removed);
}

absl::StatusOr<int64_t> EraseKeyFramesOf(Connection& connection, MapId map, SessionId session) {
  {
    Query ids(connection, kSelectOfSession);
    ids.Bind(map).Bind(session);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, ids.Step());
      if (!row) break;
      SEMMAP_RETURN_IF_ERROR(EraseKeyFrameCell(connection, map, ids.IdAt<KeyFrameId>(0)));
    }
  }
  const absl::Status status = RunQuery(connection, kDeleteOfSession, map, session);
  if (IsConstraintViolation(status)) {
    return absl::FailedPreconditionError(
        "reset: frames of another session refer to this session's keyframes");
  }
  SEMMAP_RETURN_IF_ERROR(status);
  return connection.changes();
}

}  // namespace semmap::storage::sqlite
