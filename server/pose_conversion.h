#pragma once

#include "absl/status/statusor.h"
#include "semmap/v1/pose.pb.h"
#include "slam/geometry/se3.h"

namespace semmap::server {

v1::Pose ToProto(const SE3& pose);
v1::Similarity ToProto(const Sim3& similarity);
v1::Vector3 ToProto(const Eigen::Vector3d& vector);
v1::PoseCovariance ToProto(const Matrix6d& covariance);

Eigen::Vector3d FromProto(const v1::Vector3& vector);
// INVALID_ARGUMENT when a number is not finite or the quaternion's norm is not near 1.
absl::StatusOr<SE3> FromProto(const v1::Pose& pose);

}  // namespace semmap::server
