#include "storage/sqlite/map_repair.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "slam/common/status_macros.h"
#include "storage/geometry_codec.h"
#include "storage/observation_codec.h"
#include "storage/sqlite/feature_rows.h"
#include "storage/sqlite/frame_rows.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/spatial_index.h"

namespace semmap::storage::sqlite {
namespace {

constexpr int kCellsPerStep = 1000;

constexpr char kSelectKeyFrameIds[] =
    "SELECT keyframe_id FROM keyframes WHERE map_id = ? ORDER BY keyframe_id";
constexpr char kSelectIndexedKeyFrames[] =
    "SELECT id & 1099511627775 FROM keyframe_cells WHERE map_min >= 2 * ?1 AND map_max <= 2 * ?1 + 1";
constexpr char kDeleteFramesOf[] = "DELETE FROM frames WHERE map_id = ? AND keyframe_id = ?";
constexpr char kDeleteKeyFrame[] = "DELETE FROM keyframes WHERE map_id = ? AND keyframe_id = ?";
constexpr char kDeleteObservations[] =
    "DELETE FROM keyframe_observations WHERE map_id = ? AND keyframe_id = ?";
constexpr char kSetObservationCount[] =
    "UPDATE keyframes SET observation_count = ? WHERE map_id = ? AND keyframe_id = ?";
constexpr char kSetParent[] =
    "UPDATE keyframes SET parent_id = nullif(?, 0) WHERE map_id = ? AND keyframe_id = ?";
constexpr char kSetPoint[] =
    "UPDATE points SET observation_count = ?, reference_keyframe_id = ?, cell_key = ? WHERE point_key = ?";
constexpr char kSelectFrames[] =
    "SELECT session_id, sequence, keyframe_from_camera FROM frames WHERE map_id = ?";
constexpr char kDeleteFrame[] = "DELETE FROM frames WHERE map_id = ? AND session_id = ? AND sequence = ?";
constexpr char kDeleteOrphanedFrames[] =
    "DELETE FROM frames WHERE map_id = ?1 AND keyframe_id NOT IN (SELECT keyframe_id FROM keyframes WHERE "
    "map_id = ?1)";
constexpr char kCountFrames[] =
    "UPDATE sessions SET stored_frames = (SELECT count(*) FROM frames WHERE frames.map_id = sessions.map_id "
    "AND "
    "frames.session_id = sessions.session_id) WHERE map_id = ?";
constexpr char kCountMap[] =
    "UPDATE maps SET version = version + 1, updated_at = unixepoch() * 1000000000, keyframe_count = ?2, "
    "point_count = ?3, last_keyframe_id = max(last_keyframe_id, ?4), last_point_id = max(last_point_id, ?5) "
    "WHERE map_id = ?1";

struct PointFacts {
  Eigen::Vector3d position_in_map;
  KeyFrameId reference_keyframe;
  uint32_t observations = 0;
  KeyFrameId first_observer;
};

struct KeyFrameFacts {
  SE3 map_from_camera;
  KeyFrameId parent;
};

class Repair {
 public:
  Repair(Connection& connection, MapId map) : connection_(connection), map_(map) {}

  absl::Status Run() {
    SEMMAP_RETURN_IF_ERROR(ReadKeyFrames());
    SEMMAP_RETURN_IF_ERROR(RemoveBrokenKeyFrames());
    SEMMAP_RETURN_IF_ERROR(RepairFamilyTree());
    SEMMAP_RETURN_IF_ERROR(ReadPoints());
    SEMMAP_RETURN_IF_ERROR(RepairObservations());
    SEMMAP_RETURN_IF_ERROR(RepairPoints());
    SEMMAP_RETURN_IF_ERROR(RebuildKeyFrameCells());
    SEMMAP_RETURN_IF_ERROR(RepairFrames());
    return Count();
  }

 private:
  // --- Keyframes

  absl::Status ReadKeyFrames() {
    std::vector<KeyFrameId> ids;
    {
      Query rows(connection_, kSelectKeyFrameIds);
      rows.Bind(map_);
      while (true) {
        SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
        if (!row) break;
        ids.push_back(rows.IdAt<KeyFrameId>(0));
      }
    }
    for (const KeyFrameId id : ids) {
      const absl::StatusOr<KeyFrameEntry> entry = ReadKeyFrame(connection_, map_, id);
      if (absl::IsDataLoss(entry.status())) {
        broken_.push_back(id);
      } else if (!entry.ok()) {
        return entry.status();
      } else {
        keyframes_[id] = {entry->record.map_from_camera, entry->record.parent};
      }
    }
    return absl::OkStatus();
  }

  absl::Status RemoveBrokenKeyFrames() {
    for (const KeyFrameId id : broken_) {
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kDeleteFramesOf, map_, id));
      SEMMAP_RETURN_IF_ERROR(EraseKeyFrameCell(connection_, map_, id));
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kDeleteKeyFrame, map_, id));
    }
    return absl::OkStatus();
  }

  // A keyframe whose parents lead nowhere or back to itself becomes a child of the oldest keyframe, which has
  // none.
  absl::Status RepairFamilyTree() {
    if (keyframes_.empty()) return absl::OkStatus();
    const KeyFrameId oldest = keyframes_.begin()->first;
    for (auto& [id, facts] : keyframes_) {
      if (!facts.parent.IsValid() || LeadsToRoot(id)) continue;
      facts.parent = id == oldest ? KeyFrameId() : oldest;
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kSetParent, facts.parent, map_, id));
    }
    // The oldest may itself have led back to one that now is its child.
    if (LeadsToRoot(oldest)) return absl::OkStatus();
    keyframes_[oldest].parent = KeyFrameId();
    return RunQuery(connection_, kSetParent, KeyFrameId(), map_, oldest);
  }

  bool LeadsToRoot(KeyFrameId id) const {
    for (size_t steps = 0; steps <= keyframes_.size(); ++steps) {
      const auto found = keyframes_.find(id);
      if (found == keyframes_.end()) return false;
      if (!found->second.parent.IsValid()) return true;
      id = found->second.parent;
    }
    return false;
  }

  absl::Status RebuildKeyFrameCells() {
    std::vector<KeyFrameId> indexed;
    {
      Query rows(connection_, kSelectIndexedKeyFrames);
      rows.Bind(map_);
      while (true) {
        SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
        if (!row) break;
        indexed.push_back(rows.IdAt<KeyFrameId>(0));
      }
    }
    for (const KeyFrameId id : indexed) {
      if (!keyframes_.contains(id)) SEMMAP_RETURN_IF_ERROR(EraseKeyFrameCell(connection_, map_, id));
    }
    for (const auto& [id, facts] : keyframes_) {
      const Cell cell = CellOf(facts.map_from_camera.translation(), kKeyFrameCell);
      SEMMAP_RETURN_IF_ERROR(PutKeyFrameCell(connection_, map_, id, cell));
    }
    return absl::OkStatus();
  }

  // --- Points

  absl::Status ReadPoints() {
    std::vector<MapPointId> broken;
    {
      Query rows(connection_, kSelectAllPoints);
      BindPointsBehind(rows, map_, MapPointId());
      while (true) {
        SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
        if (!row) break;
        MapPointRecord point;
        const bool decoded = ReadPointRow(rows, &point).ok();
        if (decoded && point.position_in_map.allFinite() && point.normal.allFinite()) {
          points_[point.id] = {point.position_in_map, point.reference_keyframe, 0, KeyFrameId()};
        } else {
          broken.push_back(point.id);
        }
      }
    }
    for (const MapPointId id : broken) SEMMAP_RETURN_IF_ERROR(ErasePoint(connection_, map_, id).status());
    return absl::OkStatus();
  }

  absl::Status RepairObservations() {
    for (const auto& [id, facts] : keyframes_) {
      absl::StatusOr<KeyFrameObservations> observations = ReadObservations(connection_, map_, id);
      if (absl::IsDataLoss(observations.status())) {
        SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kDeleteObservations, map_, id));
        SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kSetObservationCount, 0, map_, id));
        continue;
      }
      SEMMAP_RETURN_IF_ERROR(observations.status());
      KeepSound(&*observations);
      SEMMAP_RETURN_IF_ERROR(WriteObservations(connection_, map_, *observations, &writing_));
    }
    return absl::OkStatus();
  }

  // Leaves each point that exists seen once, and notes by whom.
  void KeepSound(KeyFrameObservations* observations) {
    std::set<MapPointId> seen;
    for (MapPointId& id : observations->point_of_keypoint) {
      if (!id.IsValid()) continue;
      const auto point = points_.find(id);
      if (point == points_.end() || !seen.insert(id).second) {
        id = MapPointId();
        continue;
      }
      PointFacts& facts = point->second;
      ++facts.observations;
      if (!facts.first_observer.IsValid() || observations->id < facts.first_observer) {
        facts.first_observer = observations->id;
      }
    }
  }

  absl::Status RepairPoints() {
    SEMMAP_ASSIGN_OR_RETURN(const MapPlacement placement, ReadPlacement(connection_, map_));
    bool no_cells = false;
    while (!no_cells) {
      SEMMAP_ASSIGN_OR_RETURN(no_cells, ErasePointCells(connection_, map_, kCellsPerStep));
    }
    std::set<int64_t> cells;
    for (auto& [id, facts] : points_) {
      if (facts.observations == 0) {
        SEMMAP_RETURN_IF_ERROR(ErasePoint(connection_, map_, id).status());
        continue;
      }
      if (!keyframes_.contains(facts.reference_keyframe)) facts.reference_keyframe = facts.first_observer;
      const Cell cell = CellOf(facts.position_in_map, placement.cell_size);
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kSetPoint, facts.observations, facts.reference_keyframe,
                                      PackCell(cell), PointKey(map_, id)));
      if (cells.insert(PackCell(cell)).second) SEMMAP_RETURN_IF_ERROR(AddPointCell(connection_, map_, cell));
    }
    std::erase_if(points_, [](const auto& point) { return point.second.observations == 0; });
    return absl::OkStatus();
  }

  // --- Frames and figures

  absl::Status RepairFrames() {
    std::vector<std::pair<SessionId, uint64_t>> broken;
    {
      Query rows(connection_, kSelectFrames);
      rows.Bind(map_);
      while (true) {
        SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
        if (!row) break;
        const absl::StatusOr<SE3> pose = DecodePose(rows.Bytes(2));
        if (!pose.ok() || !pose->IsFinite()) broken.emplace_back(rows.IdAt<SessionId>(0), rows.Unsigned(1));
      }
    }
    for (const auto& [session, sequence] : broken) {
      SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kDeleteFrame, map_, session, sequence));
    }
    SEMMAP_RETURN_IF_ERROR(RunQuery(connection_, kDeleteOrphanedFrames, map_));
    return RunQuery(connection_, kCountFrames, map_);
  }

  absl::Status Count() {
    KeyFrameId last_keyframe;
    MapPointId last_point;
    for (const auto& [id, facts] : keyframes_) last_keyframe = std::max(last_keyframe, id);
    for (const auto& [id, facts] : points_) last_point = std::max(last_point, id);
    return RunQuery(connection_, kCountMap, map_, keyframes_.size(), points_.size(), last_keyframe,
                    last_point);
  }

  Connection& connection_;
  const MapId map_;
  FeatureWriting writing_;
  std::map<KeyFrameId, KeyFrameFacts> keyframes_;
  std::vector<KeyFrameId> broken_;
  std::map<MapPointId, PointFacts> points_;
};

}  // namespace

absl::Status RepairMapRows(Connection& connection, MapId map) {
  SEMMAP_RETURN_IF_ERROR(RequireMap(connection, map));
  return Repair(connection, map).Run();
}

}  // namespace semmap::storage::sqlite
