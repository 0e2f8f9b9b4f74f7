#include "client/cli/session_trajectory.h"

#include "client/names.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

constexpr int kNumbersPerPose = 7;  // tx ty tz qx qy qz qw

absl::Status Append(const v1::TrajectoryColumns& columns, SequencedPoses* poses) {
  const int count = columns.sequences_size();
  if (columns.timestamps_ns_size() != count || columns.poses_size() != kNumbersPerPose * count) {
    return absl::DataLossError("the server sent a trajectory whose columns differ in length");
  }
  for (int i = 0; i < count; ++i) {
    const double* n = columns.poses().data() + std::ptrdiff_t{kNumbersPerPose} * i;
    const SE3 map_from_camera(Eigen::Quaterniond(n[6], n[3], n[4], n[5]), Eigen::Vector3d(n[0], n[1], n[2]));
    (*poses)[columns.sequences(i)] = {columns.timestamps_ns(i), map_from_camera};
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::map<std::string, SequencedPoses>> FetchTrajectories(Client& client,
                                                                        const std::string& map,
                                                                        const std::string& session) {
  v1::GetTrajectoryRequest request;
  request.set_map(MapName(map));
  if (!session.empty()) request.set_session(SessionName(session));
  std::map<std::string, SequencedPoses> sessions;
  absl::Status malformed;
  const absl::Status status = client.GetTrajectory(request, [&](const v1::GetTrajectoryResponse& response) {
    malformed = Append(response.trajectory(), &sessions[response.session()]);
    return malformed.ok();
  });
  SEMMAP_RETURN_IF_ERROR(malformed);
  SEMMAP_RETURN_IF_ERROR(status);
  return sessions;
}

Trajectory WithHoles(const SequencedPoses& poses) {
  Trajectory trajectory;
  for (const auto& [sequence, pose] : poses) trajectory.poses.push_back(pose);
  return trajectory;
}

Trajectory WithoutHoles(const SequencedPoses& poses, uint64_t first, uint64_t last, uint64_t* filled) {
  Trajectory trajectory;
  trajectory.timed = false;
  StampedPose latest;
  *filled = 0;
  for (uint64_t sequence = first; sequence <= last; ++sequence) {
    const auto pose = poses.find(sequence);
    if (pose == poses.end()) {
      ++*filled;
    } else {
      latest = pose->second;
    }
    trajectory.poses.push_back(latest);
  }
  return trajectory;
}

}  // namespace semmap::client
