// The part of keyframe_rows.h that reads.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/feature_codec.h"
#include "storage/geometry_codec.h"
#include "storage/observation_codec.h"
#include "storage/sqlite/feature_rows.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/spatial_index.h"

namespace semmap::storage::sqlite {
namespace {

constexpr size_t kMaxCandidates = size_t{1} << 20;

#define SEMMAP_KEYFRAME_COLUMNS                                                                \
  "keyframe_id, session_id, sequence, timestamp, parent_id, map_from_camera, keypoint_count, " \
  "observation_count"
constexpr char kSelectAll[] = "SELECT " SEMMAP_KEYFRAME_COLUMNS
                              " FROM keyframes WHERE map_id = ? AND keyframe_id > ? ORDER BY keyframe_id";
constexpr char kSelectOne[] =
    "SELECT " SEMMAP_KEYFRAME_COLUMNS " FROM keyframes WHERE map_id = ? AND keyframe_id = ?";
#undef SEMMAP_KEYFRAME_COLUMNS
constexpr char kSelectByTime[] =
    "SELECT keyframe_id FROM keyframes WHERE map_id = ? AND timestamp >= ? AND timestamp < ? LIMIT ?";
constexpr char kSelectObservations[] =
    "SELECT k.keypoint_count, o.observations FROM keyframes k LEFT JOIN keyframe_observations o "
    "USING (map_id, keyframe_id) WHERE k.map_id = ? AND k.keyframe_id = ?";

absl::Status Damaged(KeyFrameId id, const absl::Status& status) {
  return absl::DataLossError(absl::StrCat("keyframe ", id.value(), ": ", status.message()));
}

absl::Status NoSuchKeyFrame(MapId map, KeyFrameId id) {
  return absl::NotFoundError(absl::StrCat("no keyframe ", id.value(), " in map ", map.value()));
}

absl::StatusOr<KeyFrameEntry> ReadRow(const Query& row) {
  KeyFrameEntry entry;
  entry.record.id = row.IdAt<KeyFrameId>(0);
  entry.session = row.IdAt<SessionId>(1);
  entry.record.sequence = row.Unsigned(2);
  entry.record.timestamp = row.Int(3);
  entry.record.parent = row.IdAt<KeyFrameId>(4);  // NULL reads as 0: none
  absl::StatusOr<SE3> pose = DecodePose(row.Bytes(5));
  if (!pose.ok()) return Damaged(entry.record.id, pose.status());
  entry.record.map_from_camera = *pose;
  entry.keypoint_count = static_cast<uint32_t>(row.Int(6));
  entry.observation_count = static_cast<uint32_t>(row.Int(7));
  return entry;
}

absl::Status AddStoredFeatures(Connection& connection, MapId map, KeyFrameEntry* entry) {
  if (entry->keypoint_count > kMaxKeypoints) {
    return Damaged(entry->record.id, absl::DataLossError("impossible number of keypoints"));
  }
  absl::StatusOr<FrameFeatures> features =
      ReadFeatures(connection, map, entry->record.id, entry->keypoint_count);
  if (absl::IsDataLoss(features.status())) return Damaged(entry->record.id, features.status());
  SEMMAP_RETURN_IF_ERROR(features.status());
  entry->record.features = std::make_shared<const FrameFeatures>(*std::move(features));
  return absl::OkStatus();
}

auto CountSeen(const std::vector<MapPointId>& points) {
  return std::count_if(points.begin(), points.end(), [](MapPointId point) { return point.IsValid(); });
}

bool Matches(const KeyFrameQuery& query, const KeyFrameEntry& entry) {
  const KeyFrameRecord& record = entry.record;
  if (query.box.has_value() && !query.box->contains(record.map_from_camera.translation())) return false;
  if (query.time.has_value() &&
      (record.timestamp < query.time->begin || record.timestamp >= query.time->end)) {
    return false;
  }
  return !query.session.has_value() || entry.session == *query.session;
}

// Hands matching keyframes to the visitor, as many as the query wants.
class Delivery {
 public:
  Delivery(Connection& connection, MapId map, const KeyFrameQuery& query, const KeyFrameVisitor& visit)
      : connection_(connection), map_(map), query_(query), visit_(visit) {}

  // False: the query is answered.
  absl::StatusOr<bool> Offer(const Query& row) {
    SEMMAP_ASSIGN_OR_RETURN(KeyFrameEntry entry, ReadRow(row));
    if (!Matches(query_, entry)) return true;
    if (query_.with_features) SEMMAP_RETURN_IF_ERROR(AddStoredFeatures(connection_, map_, &entry));
    return visit_(entry) && (query_.limit == 0 || ++delivered_ < query_.limit);
  }

 private:
  Connection& connection_;
  MapId map_;
  const KeyFrameQuery& query_;
  const KeyFrameVisitor& visit_;
  size_t delivered_ = 0;
};

absl::StatusOr<std::optional<std::vector<uint64_t>>> FindByTime(Connection& connection, MapId map,
                                                                const TimeRange& time) {
  Query select(connection, kSelectByTime);
  select.Bind(map).Bind(time.begin).Bind(time.end).Bind(kMaxCandidates + 1);
  std::vector<uint64_t> ids;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) break;
    ids.push_back(select.Unsigned(0));
  }
  if (ids.size() > kMaxCandidates) return std::nullopt;
  std::sort(ids.begin(), ids.end());
  return ids;
}

absl::StatusOr<std::optional<std::vector<uint64_t>>> FindByIndex(Connection& connection, MapId map,
                                                                 const KeyFrameQuery& query) {
  if (query.box.has_value()) return FindKeyFrames(connection, map, *query.box, kMaxCandidates);
  if (query.time.has_value()) return FindByTime(connection, map, *query.time);
  return std::nullopt;
}

absl::Status VisitAll(Connection& connection, MapId map, KeyFrameId after, Delivery* delivery) {
  Query rows(connection, kSelectAll);
  rows.Bind(map).Bind(after);
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
    if (!row) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(const bool more, delivery->Offer(rows));
    if (!more) return absl::OkStatus();
  }
}

absl::Status VisitCandidates(Connection& connection, MapId map, std::span<const uint64_t> ids,
                             Delivery* delivery) {
  Query select(connection, kSelectOne);
  for (const uint64_t id : ids) {
    select.Bind(map).Bind(id);
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (row) {
      SEMMAP_ASSIGN_OR_RETURN(const bool more, delivery->Offer(select));
      if (!more) return absl::OkStatus();
    }
    select.Reset();
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status VisitKeyFrames(Connection& connection, MapId map, const KeyFrameQuery& query,
                            const KeyFrameVisitor& visit) {
  Delivery delivery(connection, map, query, visit);
  SEMMAP_ASSIGN_OR_RETURN(const auto candidates, FindByIndex(connection, map, query));
  if (!candidates.has_value()) return VisitAll(connection, map, query.after, &delivery);
  const auto first = std::upper_bound(candidates->begin(), candidates->end(), query.after.value());
  return VisitCandidates(connection, map, std::span<const uint64_t>(first, candidates->end()), &delivery);
}

absl::StatusOr<KeyFrameEntry> ReadKeyFrame(Connection& connection, MapId map, KeyFrameId keyframe) {
  Query select(connection, kSelectOne);
  select.Bind(map).Bind(keyframe);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return NoSuchKeyFrame(map, keyframe);
  SEMMAP_ASSIGN_OR_RETURN(KeyFrameEntry entry, ReadRow(select));
  SEMMAP_RETURN_IF_ERROR(AddStoredFeatures(connection, map, &entry));
  return entry;
}

absl::StatusOr<KeyFrameObservations> ReadObservations(Connection& connection, MapId map,
                                                      KeyFrameId keyframe) {
  Query select(connection, kSelectObservations);
  select.Bind(map).Bind(keyframe);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return NoSuchKeyFrame(map, keyframe);
  const uint64_t keypoints = select.Unsigned(0);
  if (keypoints > kMaxKeypoints)
    return Damaged(keyframe, absl::DataLossError("impossible number of keypoints"));
  const absl::StatusOr<std::vector<uint32_t>> kept = ReadKeptKeypoints(connection, map, keyframe, keypoints);
  if (absl::IsDataLoss(kept.status())) return Damaged(keyframe, kept.status());
  SEMMAP_RETURN_IF_ERROR(kept.status());
  KeyFrameObservations observations{keyframe, std::vector<MapPointId>(kept->size()), nullptr};
  if (select.IsNull(1)) return observations;
  const absl::StatusOr<std::vector<MapPointId>> points = DecodeObservations(select.Bytes(1));
  if (!points.ok()) return Damaged(keyframe, points.status());
  if (points->size() != keypoints) {
    return Damaged(keyframe, absl::DataLossError("observations are not as long as the keypoints"));
  }
  for (size_t i = 0; i < kept->size(); ++i) observations.point_of_keypoint[i] = (*points)[(*kept)[i]];
  if (CountSeen(observations.point_of_keypoint) != CountSeen(*points)) {
    return Damaged(keyframe, absl::DataLossError("a point is seen through a keypoint that is not stored"));
  }
  return observations;
}

}  // namespace semmap::storage::sqlite
