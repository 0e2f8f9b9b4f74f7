#include "slam/geometry/alignment.h"

#include <cmath>

#include <Eigen/SVD>

#include "absl/strings/str_cat.h"

namespace semmap {
namespace {

// Second singular value of the covariance, relative to the first, under which the points count as one line:
// a millionth of the length as thickness in both sets.
constexpr double kMinSingularRatio = 1e-12;

// Means and second moments of the pairs, by two passes so that coordinates far from the origin keep their
// digits.
struct PairMoments {
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_mean = Eigen::Vector3d::Zero();
  double source_variance = 0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // target * source^T
};

PairMoments Moments(std::span<const Eigen::Vector3d> source, std::span<const Eigen::Vector3d> target) {
  PairMoments moments;
  const double weight = 1.0 / static_cast<double>(source.size());
  for (size_t i = 0; i < source.size(); ++i) {
    moments.source_mean += weight * source[i];
    moments.target_mean += weight * target[i];
  }
  for (size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d from_mean = source[i] - moments.source_mean;
    moments.source_variance += weight * from_mean.squaredNorm();
    moments.covariance += weight * (target[i] - moments.target_mean) * from_mean.transpose();
  }
  return moments;
}

}  // namespace

absl::StatusOr<Sim3> AlignPoints(std::span<const Eigen::Vector3d> source,
                                 std::span<const Eigen::Vector3d> target, bool with_scale) {
  if (source.size() != target.size() || source.size() < 3) {
    return absl::InvalidArgumentError(absl::StrCat("alignment needs at least 3 pairs of points, got ",
                                                   source.size(), " and ", target.size()));
  }
  const PairMoments moments = Moments(source, target);
  if (!moments.covariance.allFinite() || !std::isfinite(moments.source_variance)) {
    return absl::InvalidArgumentError("alignment of points that are not finite");
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moments.covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d singular = svd.singularValues();
  if (!(singular(1) > kMinSingularRatio * singular(0))) {
    return absl::InvalidArgumentError("alignment of points that lie on one line");
  }
  // A mirror image would fit better than any rotation when the determinants disagree: turn the weakest axis.
  const bool mirrored = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0;
  const Eigen::Vector3d signs(1, 1, mirrored ? -1 : 1);
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const double scale = with_scale ? singular.dot(signs) / moments.source_variance : 1.0;
  const Eigen::Vector3d translation = moments.target_mean - scale * (rotation * moments.source_mean);
  return Sim3{scale, SE3(rotation, translation)};
}

}  // namespace semmap
