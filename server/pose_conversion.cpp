#include "server/pose_conversion.h"

#include <cmath>

namespace semmap::server {
namespace {

constexpr double kMaxNormError = 1e-3;

}  // namespace

v1::Vector3 ToProto(const Eigen::Vector3d& vector) {
  v1::Vector3 proto;
  proto.set_x(vector.x());
  proto.set_y(vector.y());
  proto.set_z(vector.z());
  return proto;
}

v1::Pose ToProto(const SE3& pose) {
  v1::Pose proto;
  *proto.mutable_translation() = ToProto(pose.translation());
  const Eigen::Quaterniond& q = pose.rotation();
  proto.mutable_rotation()->set_x(q.x());
  proto.mutable_rotation()->set_y(q.y());
  proto.mutable_rotation()->set_z(q.z());
  proto.mutable_rotation()->set_w(q.w());
  return proto;
}

v1::Similarity ToProto(const Sim3& similarity) {
  v1::Similarity proto;
  proto.set_scale(similarity.scale);
  *proto.mutable_pose() = ToProto(similarity.rigid);
  return proto;
}

v1::PoseCovariance ToProto(const Matrix6d& covariance) {
  v1::PoseCovariance proto;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) proto.add_upper_triangle(covariance(row, column));
  }
  return proto;
}

Eigen::Vector3d FromProto(const v1::Vector3& vector) { return {vector.x(), vector.y(), vector.z()}; }

absl::StatusOr<SE3> FromProto(const v1::Pose& pose) {
  const Eigen::Vector3d translation = FromProto(pose.translation());
  const v1::Quaternion& r = pose.rotation();
  const Eigen::Quaterniond rotation(r.w(), r.x(), r.y(), r.z());
  if (!translation.allFinite()) return absl::InvalidArgumentError("translation is not finite");
  // Written so that not-a-number fails.
  if (!(std::abs(rotation.norm() - 1.0) <= kMaxNormError)) {
    return absl::InvalidArgumentError("rotation is not a unit quaternion");
  }
  return SE3(rotation, translation);
}

}  // namespace semmap::server
