#include "storage/sqlite/summary.h"

#include <array>
#include <filesystem>

#include "slam/common/status_macros.h"
#include "storage/sqlite/frame_rows.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kSelectPoints[] =
    "SELECT semantic_class, x, y, z FROM points WHERE point_key > ? AND point_key < ?";
constexpr char kSelectTimes[] = "SELECT min(timestamp), max(timestamp) FROM keyframes WHERE map_id = ?";
constexpr char kCountSessions[] = "SELECT count(*) FROM sessions WHERE map_id = ?";
constexpr char kSumFeatures[] = "SELECT sum(length(features)) FROM keyframe_features WHERE map_id = ?";
constexpr char kSumObservations[] =
    "SELECT sum(length(observations)) FROM keyframe_observations WHERE map_id = ?";

absl::Status SummarizePoints(Connection& connection, MapSummary* summary) {
  std::array<uint64_t, 256> counts{};
  Query points(connection, kSelectPoints);
  BindPointsBehind(points, summary->map.id, MapPointId());
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, points.Step());
    if (!row) break;
    ++counts[static_cast<uint8_t>(points.Int(0))];
    summary->point_extent.extend(Eigen::Vector3d(points.Real(1), points.Real(2), points.Real(3)));
  }
  for (size_t semantic_class = 0; semantic_class < counts.size(); ++semantic_class) {
    if (counts[semantic_class] == 0) continue;
    summary->points_per_class.push_back({static_cast<uint8_t>(semantic_class), counts[semantic_class]});
  }
  return absl::OkStatus();
}

absl::Status SummarizeTrajectories(Connection& connection, MapSummary* summary) {
  SessionId session;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  return VisitTrajectory(connection, summary->map.id, TrajectoryQuery{}, [&](const TrajectoryPose& pose) {
    const Eigen::Vector3d& position = pose.map_from_camera.translation();
    if (pose.session == session) summary->trajectory_length += (position - last).norm();
    session = pose.session;
    last = position;
    ++summary->frame_count;
    return true;
  });
}

absl::Status SummarizeTimes(Connection& connection, MapSummary* summary) {
  Query times(connection, kSelectTimes);
  times.Bind(summary->map.id);
  SEMMAP_RETURN_IF_ERROR(times.Step().status());
  summary->first_keyframe_time = times.Int(0);
  summary->last_keyframe_time = times.Int(1);
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> Total(Connection& connection, const char* sql, MapId map) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t total, QueryInteger(connection, sql, map));
  return static_cast<uint64_t>(total);
}

}  // namespace

absl::StatusOr<MapSummary> SummarizeMap(Connection& connection, MapId map) {
  MapSummary summary;
  SEMMAP_ASSIGN_OR_RETURN(summary.map, ReadMap(connection, map));
  summary.camera_extent = summary.map.camera_extent;
  SEMMAP_RETURN_IF_ERROR(SummarizePoints(connection, &summary));
  SEMMAP_RETURN_IF_ERROR(SummarizeTrajectories(connection, &summary));
  SEMMAP_RETURN_IF_ERROR(SummarizeTimes(connection, &summary));
  SEMMAP_ASSIGN_OR_RETURN(summary.session_count, Total(connection, kCountSessions, map));
  SEMMAP_ASSIGN_OR_RETURN(summary.feature_bytes, Total(connection, kSumFeatures, map));
  SEMMAP_ASSIGN_OR_RETURN(summary.observation_bytes, Total(connection, kSumObservations, map));
  SEMMAP_ASSIGN_OR_RETURN(summary.database_bytes, DatabaseBytes(connection));
  return summary;
}

absl::StatusOr<uint64_t> DatabaseBytes(Connection& connection) {
  uint64_t total = 0;
  for (const char* suffix : {"", "-wal"}) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(connection.path() + suffix, error);
    // The log comes and goes.
    if (!error) total += size;
  }
  return total;
}

}  // namespace semmap::storage::sqlite
