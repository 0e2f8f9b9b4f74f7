#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"

namespace semmap {

// Readers refuse what they do not understand (NOT_FOUND for a missing file, INVALID_ARGUMENT "file:line:
// reason" for the rest) rather than skip it, and read at most kMaxPoses poses.
constexpr size_t kMaxPoses = 10'000'000;

enum class TrajectoryFormat {
  kTum,    // "seconds tx ty tz qx qy qz qw", '#' comments; times must not go back
  kKitti,  // the 12 numbers of the 3x4 matrix map_from_camera, row by row, one line a frame, no times
};

absl::StatusOr<Trajectory> ReadTumTrajectory(const std::string& path);
absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& path);
absl::StatusOr<Trajectory> ReadTrajectory(const std::string& path, TrajectoryFormat format);

// KITTI's times.txt: seconds in decimal or scientific notation, one line a frame, growing.
absl::StatusOr<std::vector<TimestampNs>> ReadTimes(const std::string& path);
// Gives a KITTI trajectory its times; INVALID_ARGUMENT when there are fewer times than poses.
absl::Status AttachTimes(const std::vector<TimestampNs>& times, Trajectory* trajectory);

// Numbers carry 17 significant digits: equal text means equal poses.
std::string FormatTrajectory(const Trajectory& trajectory, TrajectoryFormat format);
// UNAVAILABLE when the file cannot be written.
absl::Status WriteTrajectory(const std::string& path, const Trajectory& trajectory, TrajectoryFormat format);

}  // namespace semmap
