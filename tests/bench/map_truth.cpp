#include "tests/bench/map_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "client/cli/rig_conversion.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/recall.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/geometry/alignment.h"

namespace semmap::bench {
namespace {

// A picture shows a place of the map when a keyframe stood so near and looked so nearly the same way.
constexpr double kNear = 8.0;
constexpr double kNearAngle = 45 * std::numbers::pi / 180;
// Frames that align a neighbourhood.
constexpr size_t kNeighbours = 10;

SE3 Apply(const Sim3& world_from_map, const SE3& map_from_camera) {
  return SE3(world_from_map.rigid.rotation() * map_from_camera.rotation(),
             world_from_map * map_from_camera.translation());
}

absl::StatusOr<std::map<TimestampNs, SE3>> ReadTruth(const std::string& times_file,
                                                     const std::string& truth_file) {
  SEMMAP_ASSIGN_OR_RETURN(Trajectory truth, ReadKittiTrajectory(truth_file));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TimestampNs> times, ReadTimes(times_file));
  SEMMAP_RETURN_IF_ERROR(AttachTimes(times, &truth));
  std::map<TimestampNs, SE3> by_time;
  for (const StampedPose& pose : truth.poses) by_time.emplace(pose.timestamp, pose.map_from_camera);
  return by_time;
}

}  // namespace

absl::StatusOr<MapTruth> MapTruth::Read(client::Client& client, const std::string& map,
                                        const std::string& times, const std::string& truth, bool with_scale) {
  SEMMAP_ASSIGN_OR_RETURN(const auto by_time, ReadTruth(times, truth));
  MapTruth result;
  result.with_scale_ = with_scale;
  std::vector<Eigen::Vector3d> in_map;
  std::vector<Eigen::Vector3d> in_world;
  // Others that drove in the map later have times of their own.
  v1::ListSessionsRequest request;
  request.set_map("maps/" + map);
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<v1::Session> sessions, client.ListSessions(request));
  if (sessions.empty()) return absl::FailedPreconditionError(map + " has no session");
  v1::QueryKeyFramesRequest keyframes;
  keyframes.set_map(map);
  keyframes.set_session(sessions.front().name());
  SEMMAP_RETURN_IF_ERROR(client.QueryKeyFrames(keyframes, [&](const v1::KeyFrame& keyframe) {
    const auto pose = by_time.find(keyframe.timestamp_ns());
    if (pose == by_time.end()) return true;
    result.world_from_keyframe_.push_back(pose->second);
    in_world.push_back(pose->second.translation());
    in_map.push_back(client::FromProto(keyframe.map_from_camera()).translation());
    return true;
  }));
  SEMMAP_ASSIGN_OR_RETURN(result.world_from_map_, AlignPoints(in_map, in_world, with_scale));
  v1::GetTrajectoryRequest trajectory;
  trajectory.set_map(map);
  trajectory.set_session(sessions.front().name());
  SEMMAP_RETURN_IF_ERROR(client.GetTrajectory(trajectory, [&](const v1::GetTrajectoryResponse& response) {
    const v1::TrajectoryColumns& columns = response.trajectory();
    for (int i = 0; i < columns.sequences_size(); ++i) {
      const auto pose = by_time.find(columns.timestamps_ns(i));
      if (pose == by_time.end()) continue;
      const double* p = columns.poses().data() + 7 * i;
      result.frames_.push_back(
          {pose->second, SE3(Eigen::Quaterniond(p[6], p[3], p[4], p[5]), {p[0], p[1], p[2]})});
    }
    return true;
  }));
  return result;
}

SE3 MapTruth::ToWorld(const SE3& map_from_camera) const { return Apply(world_from_map_, map_from_camera); }

// The rotation comes from the frames' own, since a short piece of road is nearly straight and its positions
// do not tell how it is rolled; scale and translation come from the positions.
SE3 MapTruth::ToWorldNear(const SE3& map_from_camera, const Eigen::Vector3d& world_near) const {
  std::vector<const Frame*> near;
  for (const Frame& frame : frames_) near.push_back(&frame);
  const size_t count = std::min(kNeighbours, near.size());
  const auto distance = [&](const Frame* frame) {
    return (frame->world_from_camera.translation() - world_near).squaredNorm();
  };
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end(),
                    [&](const Frame* a, const Frame* b) { return distance(a) < distance(b); });
  near.resize(count);
  Eigen::Vector3d world_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d map_mean = Eigen::Vector3d::Zero();
  Eigen::Vector4d rotation = Eigen::Vector4d::Zero();
  for (const Frame* frame : near) {
    world_mean += frame->world_from_camera.translation() / static_cast<double>(count);
    map_mean += frame->map_from_camera.translation() / static_cast<double>(count);
    const Eigen::Quaterniond one =
        frame->world_from_camera.rotation() * frame->map_from_camera.rotation().conjugate();
    rotation += one.coeffs().dot(rotation) < 0 ? Eigen::Vector4d(-one.coeffs()) : one.coeffs();
  }
  double world_spread = 0;
  double map_spread = 0;
  for (const Frame* frame : near) {
    world_spread += (frame->world_from_camera.translation() - world_mean).squaredNorm();
    map_spread += (frame->map_from_camera.translation() - map_mean).squaredNorm();
  }
  Sim3 local;
  if (with_scale_ && map_spread > 0) local.scale = std::sqrt(world_spread / map_spread);
  const Eigen::Quaterniond turn = Eigen::Quaterniond(rotation).normalized();
  local.rigid = SE3(turn, world_mean - local.scale * (turn * map_mean));
  return Apply(local, map_from_camera);
}

double MapTruth::Distance(const SE3& world_from_camera) const {
  double distance = std::numeric_limits<double>::infinity();
  for (const SE3& keyframe : world_from_keyframe_)
    distance = std::min(distance, (keyframe.translation() - world_from_camera.translation()).norm());
  return distance;
}

bool MapTruth::Shows(const SE3& world_from_camera, bool any_heading) const {
  return std::any_of(world_from_keyframe_.begin(), world_from_keyframe_.end(), [&](const SE3& keyframe) {
    const PoseError apart = ComparePoses(keyframe, world_from_camera);
    return apart.translation_m < kNear && (any_heading || apart.rotation_rad < kNearAngle);
  });
}

}  // namespace semmap::bench
