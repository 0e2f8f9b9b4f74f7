#include "storage/sqlite/map_rows.h"

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/geometry_codec.h"
#include "storage/labels_codec.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {
namespace {

// When a map was changed is told by the database's own clock: whole seconds, as nanoseconds.
#define SEMMAP_NOW "unixepoch() * 1000000000"
constexpr char kInsert[] =
    "INSERT INTO maps (name, created_at, updated_at, rig, scale_known) VALUES (?1, ?2, ?2, ?3, ?4)";
#define SEMMAP_MAP_COLUMNS                                                                              \
  "map_id, name, created_at, rig, scale_known, latitude_deg, longitude_deg, altitude_m, enu_from_map, " \
  "keyframe_count, point_count, version, last_keyframe_id, last_point_id, updated_at, "                 \
  "display_name, labels, anchor_source, anchor_rms_m, revision"
constexpr char kSelectByName[] = "SELECT " SEMMAP_MAP_COLUMNS " FROM maps WHERE name = ?";
constexpr char kSelectById[] =
    "SELECT " SEMMAP_MAP_COLUMNS " FROM maps WHERE map_id = ? AND name IS NOT NULL";
constexpr char kSelectPage[] = "SELECT " SEMMAP_MAP_COLUMNS " FROM maps WHERE name > ? ORDER BY name LIMIT ?";
#undef SEMMAP_MAP_COLUMNS
constexpr char kSelectExists[] = "SELECT 1 FROM maps WHERE map_id = ? AND name IS NOT NULL";
constexpr char kSelectPoses[] = "SELECT map_from_camera FROM keyframes WHERE map_id = ?";
constexpr char kUpdateName[] =
    "UPDATE maps SET name = ?, revision = revision + 1, updated_at = " SEMMAP_NOW " WHERE map_id = ?";
constexpr char kUpdateAnchor[] =
    "UPDATE maps SET latitude_deg = ?, longitude_deg = ?, altitude_m = ?, enu_from_map = ?, anchor_source = "
    "?, "
    "anchor_rms_m = ? WHERE map_id = ?";
constexpr char kUpdateDisplayName[] = "UPDATE maps SET display_name = ? WHERE map_id = ?";
constexpr char kUpdateLabels[] = "UPDATE maps SET labels = ? WHERE map_id = ?";
constexpr char kNoteRevision[] =
    "UPDATE maps SET revision = revision + 1, updated_at = " SEMMAP_NOW " WHERE map_id = ?";
constexpr char kSelectState[] = "SELECT version, revision FROM maps WHERE map_id = ?";
constexpr char kSelectPlacement[] = "SELECT coalesce(cell_size, 0), last_point_id FROM maps WHERE map_id = ?";
constexpr char kUpdateCellSize[] = "UPDATE maps SET cell_size = ? WHERE map_id = ?";
constexpr char kUpdateGrowth[] =
    "UPDATE maps SET keyframe_count = keyframe_count + ?, point_count = point_count + ?, "
    "version = version + ?, updated_at = " SEMMAP_NOW
    ", "
    "last_keyframe_id = max(last_keyframe_id, ?), last_point_id = max(last_point_id, ?) WHERE map_id = ?";

#undef SEMMAP_NOW

absl::Status ReadAnchor(const Query& row, MapInfo* map) {
  if (row.IsNull(8)) return absl::OkStatus();
  GeoAnchor anchor{row.Real(5), row.Real(6), row.Real(7), {}};
  anchor.source = static_cast<GeoAnchor::Source>(row.Int(17));
  anchor.rms_error_m = row.Real(18);
  SEMMAP_ASSIGN_OR_RETURN(anchor.enu_from_map, DecodeSim3(row.Bytes(8)));
  map->anchor = anchor;
  return absl::OkStatus();
}

absl::Status ReadExtent(Connection& connection, MapInfo* map) {
  Query poses(connection, kSelectPoses);
  poses.Bind(map->id);
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, poses.Step());
    if (!row) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(const SE3 map_from_camera, DecodePose(poses.Bytes(0)));
    map->camera_extent.extend(map_from_camera.translation());
  }
}

absl::StatusOr<MapInfo> ReadRow(Connection& connection, const Query& row) {
  MapInfo map;
  map.id = row.IdAt<MapId>(0);
  map.name = row.Text(1);
  map.created_at = row.Int(2);
  SEMMAP_ASSIGN_OR_RETURN(map.rig, DecodeRig(row.Bytes(3)));
  map.scale_known = row.Int(4) != 0;
  SEMMAP_RETURN_IF_ERROR(ReadAnchor(row, &map));
  map.keyframe_count = row.Unsigned(9);
  map.point_count = row.Unsigned(10);
  map.version = row.Unsigned(11);
  map.last_keyframe_id = row.IdAt<KeyFrameId>(12);
  map.last_point_id = row.IdAt<MapPointId>(13);
  if (!row.IsNull(14)) map.updated_at = row.Int(14);
  map.display_name = row.Text(15);
  if (!row.IsNull(16)) {
    SEMMAP_ASSIGN_OR_RETURN(map.labels, DecodeLabels(row.Bytes(16)));
  }
  map.revision = row.Unsigned(19);
  SEMMAP_RETURN_IF_ERROR(ReadExtent(connection, &map));
  return map;
}

absl::Status WriteAnchor(Connection& connection, MapId map, const std::optional<GeoAnchor>& anchor) {
  Query update(connection, kUpdateAnchor);
  Blob enu_from_map;
  if (anchor.has_value()) {
    enu_from_map = EncodeSim3(anchor->enu_from_map);
    update.Bind(anchor->latitude_deg).Bind(anchor->longitude_deg).Bind(anchor->altitude_m);
    update.BindBlob(enu_from_map).Bind(static_cast<int>(anchor->source)).Bind(anchor->rms_error_m);
  } else {
    update.BindNull()
        .BindNull()
        .BindNull()
        .BindNull()
        .Bind(static_cast<int>(GeoAnchor::Source::kGiven))
        .Bind(0.0);
  }
  return update.Bind(map).Run();
}

absl::Status WriteDescription(Connection& connection, MapId map, const MapChanges& changes) {
  if (changes.display_name.has_value()) {
    Query update(connection, kUpdateDisplayName);
    SEMMAP_RETURN_IF_ERROR(update.BindText(*changes.display_name).Bind(map).Run());
  }
  if (changes.labels.has_value()) {
    const Blob labels = EncodeLabels(*changes.labels);
    Query update(connection, kUpdateLabels);
    SEMMAP_RETURN_IF_ERROR(update.BindBlob(labels).Bind(map).Run());
  }
  return changes.anchor.has_value() ? WriteAnchor(connection, map, *changes.anchor) : absl::OkStatus();
}

absl::Status NoSuchMap(MapId map) {
  return absl::NotFoundError(absl::StrCat("no map with id ", map.value()));
}

}  // namespace

absl::StatusOr<MapId> InsertMap(Connection& connection, const NewMap& map) {
  const Blob rig = EncodeRig(map.rig);
  Query insert(connection, kInsert);
  insert.BindText(map.name).Bind(map.created_at).BindBlob(rig).Bind(map.scale_known);
  const absl::Status status = insert.Run();
  if (IsConstraintViolation(status))
    return absl::AlreadyExistsError(absl::StrCat("map ", map.name, " exists"));
  SEMMAP_RETURN_IF_ERROR(status);
  const MapId id(static_cast<uint64_t>(connection.last_insert_rowid()));
  SEMMAP_RETURN_IF_ERROR(WriteDescription(connection, id, {map.display_name, map.labels, map.anchor}));
  return id;
}

absl::StatusOr<MapInfo> ReadMap(Connection& connection, std::string_view name) {
  Query select(connection, kSelectByName);
  select.BindText(name);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return absl::NotFoundError(absl::StrCat("no map named ", std::string(name)));
  return ReadRow(connection, select);
}

absl::StatusOr<MapInfo> ReadMap(Connection& connection, MapId map) {
  Query select(connection, kSelectById);
  select.Bind(map);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return NoSuchMap(map);
  return ReadRow(connection, select);
}

absl::StatusOr<std::vector<MapInfo>> ReadMaps(Connection& connection, const MapListQuery& query) {
  Query select(connection, kSelectPage);
  // A negative limit is none.
  select.BindText(query.after).Bind(query.limit == 0 ? -1 : static_cast<int64_t>(query.limit));
  std::vector<MapInfo> maps;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) return maps;
    SEMMAP_ASSIGN_OR_RETURN(maps.emplace_back(), ReadRow(connection, select));
  }
}

absl::Status RequireMap(Connection& connection, MapId map) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t exists, QueryInteger(connection, kSelectExists, map));
  return exists != 0 ? absl::OkStatus() : NoSuchMap(map);
}

absl::Status UpdateName(Connection& connection, MapId map, std::string_view name) {
  SEMMAP_RETURN_IF_ERROR(RequireMap(connection, map));
  Query update(connection, kUpdateName);
  const absl::Status status = update.BindText(name).Bind(map).Run();
  if (!IsConstraintViolation(status)) return status;
  return absl::AlreadyExistsError(absl::StrCat("map ", std::string(name), " exists"));
}

absl::Status UpdateDescription(Connection& connection, MapId map, const MapChanges& changes) {
  SEMMAP_RETURN_IF_ERROR(RequireMap(connection, map));
  if (changes.expected.has_value()) {
    Query state(connection, kSelectState);
    SEMMAP_RETURN_IF_ERROR(state.Bind(map).Step().status());
    if (state.Unsigned(0) != changes.expected->version || state.Unsigned(1) != changes.expected->revision) {
      return absl::AbortedError("the map was changed meanwhile");
    }
  }
  SEMMAP_RETURN_IF_ERROR(WriteDescription(connection, map, changes));
  return RunQuery(connection, kNoteRevision, map);
}

absl::StatusOr<MapPlacement> ReadPlacement(Connection& connection, MapId map) {
  Query select(connection, kSelectPlacement);
  select.Bind(map);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return NoSuchMap(map);
  return MapPlacement{select.Real(0), select.IdAt<MapPointId>(1)};
}

absl::Status SetCellSize(Connection& connection, MapId map, double cell_size) {
  return RunQuery(connection, kUpdateCellSize, cell_size, map);
}

absl::Status UpdateGrowth(Connection& connection, MapId map, const MapGrowth& growth) {
  return RunQuery(connection, kUpdateGrowth, growth.keyframes, growth.points, growth.changes_map ? 1 : 0,
                  growth.last_keyframe_id, growth.last_point_id, map);
}

}  // namespace semmap::storage::sqlite
