#include "storage/sqlite/integrity_check.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/frame_rows.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/session_rows.h"
#include "storage/sqlite/spatial_index.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kCheckDatabase[] = "PRAGMA integrity_check(100)";
constexpr char kCheckForeignKeys[] = "PRAGMA foreign_key_check";
constexpr char kCheckPointTree[] = "SELECT rtreecheck('point_cells')";
constexpr char kCheckKeyFrameTree[] = "SELECT rtreecheck('keyframe_cells')";
constexpr char kSelectKeyFrameIds[] = "SELECT keyframe_id FROM keyframes WHERE map_id = ?";
constexpr char kCountFrames[] = "SELECT count(*) FROM frames WHERE map_id = ? AND session_id = ?";
constexpr char kCountKeyFrameCells[] = "SELECT count(*) FROM keyframe_cells WHERE map_min = ?";

struct PointFacts {
  uint32_t declared_observations = 0;
  uint32_t counted_observations = 0;
  KeyFrameId reference_keyframe;
};

class IntegrityCheck {
 public:
  IntegrityCheck(Connection& connection, MapId map, size_t max_findings)
      : connection_(connection), map_(map), max_findings_(max_findings) {}

  absl::StatusOr<std::vector<IntegrityFinding>> Run() {
    // Damage in one part does not keep the others from being checked; other failures end the check.
    using Step = absl::Status (IntegrityCheck::*)();
    for (const Step step :
         {&IntegrityCheck::CheckDatabase, &IntegrityCheck::CheckForeignKeys, &IntegrityCheck::CheckTrees,
          &IntegrityCheck::CheckPoints, &IntegrityCheck::CheckKeyFrames, &IntegrityCheck::CheckPointFacts,
          &IntegrityCheck::CheckFamilyTree, &IntegrityCheck::CheckSessions, &IntegrityCheck::CheckTrajectory,
          &IntegrityCheck::CheckMap}) {
      const absl::Status status = (this->*step)();
      if (absl::IsDataLoss(status)) {
        Report("undecodable", std::string(status.message()));
      } else if (!status.ok()) {
        return status;
      }
    }
    return std::move(findings_);
  }

 private:
  template <typename... Parts>
  void Report(const char* kind, const Parts&... parts) {
    if (findings_.size() < max_findings_) findings_.push_back({kind, absl::StrCat(parts...)});
  }

  absl::Status CheckDatabase() {
    Query check(connection_, kCheckDatabase);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, check.Step());
      if (!row) return absl::OkStatus();
      if (check.Text(0) != "ok") Report("database-structure", check.Text(0));
    }
  }

  absl::Status CheckForeignKeys() {
    Query check(connection_, kCheckForeignKeys);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, check.Step());
      if (!row) return absl::OkStatus();
      Report("foreign-key", "a row of ", check.Text(0), " refers to a missing row of ", check.Text(2));
    }
  }

  absl::Status CheckTrees() {
    for (const char* sql : {kCheckPointTree, kCheckKeyFrameTree}) {
      Query check(connection_, sql);
      SEMMAP_RETURN_IF_ERROR(check.Step().status());
      if (check.Text(0) != "ok") Report("index-structure", check.Text(0));
    }
    return absl::OkStatus();
  }

  absl::Status CheckPoints() {
    SEMMAP_ASSIGN_OR_RETURN(const MapPlacement placement, ReadPlacement(connection_, map_));
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<int64_t> cells, AllPointCells(connection_, map_));
    cells_.insert(cells.begin(), cells.end());
    if (cells_.size() != cells.size()) Report("index-structure", "a cell is in the spatial index twice");
    Query rows(connection_, kSelectAllPoints);
    BindPointsBehind(rows, map_, MapPointId());
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
      if (!row) return absl::OkStatus();
      MapPointRecord point;
      const absl::Status status = ReadPointRow(rows, &point);
      if (!status.ok()) Report("undecodable", status.message());
      points_[point.id.value()] = {point.observation_count, 0, point.reference_keyframe};
      if (!point.position_in_map.allFinite() || !point.normal.allFinite()) {
        Report("not-finite", "map point ", point.id.value());
        continue;
      }
      CheckCell(point, CellKeyOfRow(rows), placement.cell_size);
    }
  }

  // A point's row says in which cell it is, and the tree knows the cell.
  void CheckCell(const MapPointRecord& point, int64_t cell_key, double cell_size) {
    if (cell_key != PackCell(CellOf(point.position_in_map, cell_size))) {
      Report("wrong-cell", "map point ", point.id.value(), " is indexed at another place");
    } else if (!cells_.contains(cell_key)) {
      Report("not-indexed", "the cell of map point ", point.id.value(), " is not in the spatial index");
    }
  }

  absl::Status CheckCell(const KeyFrameRecord& keyframe) {
    SEMMAP_ASSIGN_OR_RETURN(const std::optional<Cell> cell, GetKeyFrameCell(connection_, map_, keyframe.id));
    if (!cell.has_value()) {
      Report("not-indexed", "keyframe ", keyframe.id.value(), " is not in the spatial index");
    } else if (*cell != CellOf(keyframe.map_from_camera.translation(), kKeyFrameCell)) {
      Report("wrong-cell", "keyframe ", keyframe.id.value(), " is indexed at another place");
    }
    return absl::OkStatus();
  }

  absl::Status CheckKeyFrames() {
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<KeyFrameId> ids, KeyFrameIds());
    for (const KeyFrameId id : ids) parents_[id.value()] = 0;
    for (const KeyFrameId id : ids) {
      const absl::Status status = CheckKeyFrame(id);
      if (absl::IsDataLoss(status)) {
        Report("undecodable", status.message());
      } else if (!status.ok()) {
        return status;
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<KeyFrameId>> KeyFrameIds() {
    Query rows(connection_, kSelectKeyFrameIds);
    rows.Bind(map_);
    std::vector<KeyFrameId> ids;
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
      if (!row) return ids;
      ids.push_back(rows.IdAt<KeyFrameId>(0));
    }
  }

  absl::Status CheckKeyFrame(KeyFrameId id) {
    SEMMAP_ASSIGN_OR_RETURN(const KeyFrameObservations observations, ReadObservations(connection_, map_, id));
    CheckObservations(observations);
    SEMMAP_ASSIGN_OR_RETURN(const KeyFrameEntry entry, ReadKeyFrame(connection_, map_, id));
    parents_[id.value()] = entry.record.parent.value();
    const auto seen =
        std::count_if(observations.point_of_keypoint.begin(), observations.point_of_keypoint.end(),
                      [](MapPointId point) { return point.IsValid(); });
    if (seen != entry.observation_count) {
      Report("count-mismatch", "keyframe ", id.value(), " has ", seen, " observations, not ",
             entry.observation_count);
    }
    return CheckCell(entry.record);
  }

  void CheckObservations(const KeyFrameObservations& observations) {
    std::vector<MapPointId> seen = observations.point_of_keypoint;
    std::sort(seen.begin(), seen.end());
    for (size_t i = 0; i < seen.size(); ++i) {
      if (!seen[i].IsValid()) continue;
      if (i > 0 && seen[i] == seen[i - 1]) {
        Report("duplicate-observation", "keyframe ", observations.id.value(), " sees map point ",
               seen[i].value(), " twice");
        continue;
      }
      const auto point = points_.find(seen[i].value());
      if (point == points_.end()) {
        Report("dangling-observation", "keyframe ", observations.id.value(), " sees map point ",
               seen[i].value(), ", which does not exist");
      } else {
        ++point->second.counted_observations;
      }
    }
  }

  absl::Status CheckPointFacts() {
    for (const auto& [id, facts] : points_) {
      if (facts.declared_observations != facts.counted_observations) {
        Report("count-mismatch", "map point ", id, " is seen by ", facts.counted_observations,
               " keyframes, not ", facts.declared_observations);
      }
      if (!parents_.contains(facts.reference_keyframe.value())) {
        Report("dangling-reference", "map point ", id, ": reference keyframe ",
               facts.reference_keyframe.value(), " does not exist");
      }
    }
    return absl::OkStatus();
  }

  // Parents exist, and whoever follows them comes to an end.
  absl::Status CheckFamilyTree() {
    absl::flat_hash_map<uint64_t, uint64_t> walk_of;  // keyframe to the walk that first came by
    for (const auto& [start, first_parent] : parents_) {
      uint64_t id = start;
      while (id != 0 && walk_of.try_emplace(id, start).second) {
        const auto parent = parents_.find(id);
        if (parent == parents_.end()) {
          Report("dangling-parent", "a keyframe has parent ", id, ", which does not exist");
          break;
        }
        id = parent->second;
        if (id != 0 && walk_of.contains(id) && walk_of[id] == start) {
          Report("cycle", "keyframe ", id, " is its own ancestor");
        }
      }
    }
    return absl::OkStatus();
  }

  absl::Status CheckSessions() {
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<SessionInfo> sessions,
                            ReadSessions(connection_, map_, SessionId(), 0));
    for (const SessionInfo& session : sessions) {
      SEMMAP_ASSIGN_OR_RETURN(const int64_t frames,
                              QueryInteger(connection_, kCountFrames, map_, session.id));
      if (static_cast<uint64_t>(frames) == session.stored_frames) continue;
      Report("count-mismatch", "session ", session.name, " has ", frames, " frames, not ",
             session.stored_frames);
    }
    return absl::OkStatus();
  }

  absl::Status CheckTrajectory() {
    return VisitTrajectory(connection_, map_, TrajectoryQuery{}, [this](const TrajectoryPose& pose) {
      if (!pose.map_from_camera.IsFinite()) Report("not-finite", "frame ", pose.sequence);
      return true;
    });
  }

  absl::Status CheckMap() {
    SEMMAP_ASSIGN_OR_RETURN(const MapInfo map, ReadMap(connection_, map_));
    if (map.point_count != points_.size()) {
      Report("count-mismatch", "the map has ", points_.size(), " points, not ", map.point_count);
    }
    if (map.keyframe_count != parents_.size()) {
      Report("count-mismatch", "the map has ", parents_.size(), " keyframes, not ", map.keyframe_count);
    }
    for (const auto& [id, parent] : parents_) {
      if (id > map.last_keyframe_id.value()) Report("id-out-of-range", "keyframe ", id);
    }
    for (const auto& [id, facts] : points_) {
      if (id > map.last_point_id.value()) Report("id-out-of-range", "map point ", id);
    }
    SEMMAP_ASSIGN_OR_RETURN(const int64_t indexed,
                            QueryInteger(connection_, kCountKeyFrameCells, 2 * map_.value()));
    if (static_cast<size_t>(indexed) != parents_.size()) {
      Report("count-mismatch", "the spatial index has ", indexed, " keyframes, not ", parents_.size());
    }
    return absl::OkStatus();
  }

  Connection& connection_;
  const MapId map_;
  const size_t max_findings_;
  std::vector<IntegrityFinding> findings_;
  absl::flat_hash_set<int64_t> cells_;
  absl::flat_hash_map<uint64_t, PointFacts> points_;
  absl::flat_hash_map<uint64_t, uint64_t> parents_;  // of each keyframe; 0: none
};

}  // namespace

absl::StatusOr<std::vector<IntegrityFinding>> CheckMapIntegrity(Connection& connection, MapId map,
                                                                size_t max_findings) {
  SEMMAP_RETURN_IF_ERROR(RequireMap(connection, map));
  return IntegrityCheck(connection, map, max_findings).Run();
}

}  // namespace semmap::storage::sqlite
