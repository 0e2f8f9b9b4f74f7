#include "storage/sqlite/map_outline_rows.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/geometry_codec.h"
#include "storage/observation_codec.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/query.h"
#include "storage/words_codec.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kSelect[] =
    "SELECT k.keyframe_id, k.map_from_camera, o.observations, w.words FROM keyframes k "
    "LEFT JOIN keyframe_observations o ON o.map_id = k.map_id AND o.keyframe_id = k.keyframe_id "
    "LEFT JOIN keyframe_words w ON w.map_id = k.map_id AND w.keyframe_id = k.keyframe_id AND w.vocabulary = "
    "?2 "
    "WHERE k.map_id = ?1 ORDER BY k.keyframe_id";

absl::Status Damaged(KeyFrameId id, const absl::Status& status) {
  return absl::DataLossError(absl::StrCat("keyframe ", id.value(), ": ", status.message()));
}

absl::StatusOr<KeyFrameOutline> ReadRow(const Query& row) {
  KeyFrameOutline keyframe;
  keyframe.id = row.IdAt<KeyFrameId>(0);
  const absl::StatusOr<SE3> pose = DecodePose(row.Bytes(1));
  if (!pose.ok()) return Damaged(keyframe.id, pose.status());
  keyframe.map_from_camera = *pose;
  if (!row.IsNull(2)) {
    absl::StatusOr<std::vector<MapPointId>> points = DecodeSeenPoints(row.Bytes(2));
    if (!points.ok()) return Damaged(keyframe.id, points.status());
    keyframe.points = *std::move(points);
  }
  // Words that cannot be read are made anew from the features.
  if (!row.IsNull(3)) {
    if (auto words = DecodeWords(row.Bytes(3)); words.ok()) keyframe.words = *std::move(words);
  }
  return keyframe;
}

}  // namespace

absl::Status ReadMapOutline(Connection& connection, MapId map, uint64_t vocabulary,
                            MapOutlineReader* reader) {
  SEMMAP_ASSIGN_OR_RETURN(const MapInfo info, ReadMap(connection, map));
  SEMMAP_RETURN_IF_ERROR(reader->OnMap(info));
  Query rows(connection, kSelect);
  rows.Bind(map).Bind(vocabulary);
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
    if (!row) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(KeyFrameOutline keyframe, ReadRow(rows));
    SEMMAP_RETURN_IF_ERROR(reader->OnKeyFrame(std::move(keyframe)));
  }
}

}  // namespace semmap::storage::sqlite
