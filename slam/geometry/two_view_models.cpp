#include "slam/geometry/two_view_models.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "slam/geometry/sampling.h"

namespace semmap {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// 95 % quantiles of chi^2: a point has two degrees of freedom, the distance to a line one. Gamma is the same
// for both models so that their scores compare.
constexpr double kHomographyBound = 5.991;
constexpr double kFundamentalBound = 3.841;
constexpr double kGamma = kHomographyBound;

constexpr int kMinMatches = 8;
constexpr int kHomographySample = 4;
constexpr int kFundamentalSample = 8;
constexpr int kRefinements = 10;
constexpr double kConfidence = 0.9999;

// The similarity that moves the points' centroid to the origin and makes their mean distance sqrt(2).
Eigen::Matrix3d Normalization(const Points& points) {
  const double weight = 1.0 / static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) mean += weight * point;
  double distance = 0;
  for (const Eigen::Vector2d& point : points) distance += weight * (point - mean).norm();
  const double scale = std::sqrt(2.0) / std::max(distance, 1e-9);
  Eigen::Matrix3d transform;
  transform << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return transform;
}

Points Transform(const Eigen::Matrix3d& transform, const Points& points) {
  Points out;
  out.reserve(points.size());
  for (const Eigen::Vector2d& point : points) out.emplace_back((transform * point.homogeneous()).head<2>());
  return out;
}

// Null vector of a design matrix whose rows come one by one, as the 3x3 model that it is row by row.
class NullVector {
 public:
  void AddRow(const Vector9d& row) {
    if (rows_ < kMinimalRows) minimal_.col(rows_) = row;
    ++rows_;
    normal_ += row * row.transpose();
  }

  // Least squares by the normal matrix, which is exact enough in normalized coordinates; a minimal sample, of
  // which there are many, by a much cheaper QR decomposition.
  Eigen::Matrix3d Solve() const {
    const Vector9d vector = rows_ == kMinimalRows ? FromMinimal() : FromNormalMatrix();
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(vector.data());
  }

 private:
  static constexpr int kMinimalRows = 8;

  Vector9d FromMinimal() const {
    const Eigen::HouseholderQR<Eigen::Matrix<double, 9, kMinimalRows>> qr(minimal_);
    return qr.householderQ() * Vector9d::Unit(8);
  }
  Vector9d FromNormalMatrix() const {
    return Eigen::SelfAdjointEigenSolver<Matrix9d>(normal_).eigenvectors().col(0);
  }

  int rows_ = 0;
  Eigen::Matrix<double, 9, kMinimalRows> minimal_;
  Matrix9d normal_ = Matrix9d::Zero();
};

Eigen::Matrix3d LinearHomography(const Points& first, const Points& second, std::span<const int> sample) {
  NullVector homography;
  for (const int i : sample) {
    const Eigen::Vector2d& p = first[i];
    const Eigen::Vector2d& q = second[i];
    Vector9d row_u;
    Vector9d row_v;
    row_u << p.x(), p.y(), 1, 0, 0, 0, -q.x() * p.x(), -q.x() * p.y(), -q.x();
    row_v << 0, 0, 0, p.x(), p.y(), 1, -q.y() * p.x(), -q.y() * p.y(), -q.y();
    homography.AddRow(row_u);
    homography.AddRow(row_v);
  }
  return homography.Solve();
}

Eigen::Matrix3d LinearFundamental(const Points& first, const Points& second, std::span<const int> sample) {
  NullVector fundamental;
  for (const int i : sample) {
    const Eigen::Vector2d& p = first[i];
    const Eigen::Vector2d& q = second[i];
    Vector9d row;
    row << q.x() * p.x(), q.x() * p.y(), q.x(), q.y() * p.x(), q.y() * p.y(), q.y(), p.x(), p.y(), 1;
    fundamental.AddRow(row);
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(fundamental.Solve(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d singular = svd.singularValues();
  singular(2) = 0;  // every epipolar line goes through the epipole
  return svd.matrixU() * singular.asDiagonal() * svd.matrixV().transpose();
}

double TransferError2(const Eigen::Matrix3d& homography, const Eigen::Vector2d& from,
                      const Eigen::Vector2d& to) {
  const Eigen::Vector3d moved = homography * from.homogeneous();
  return (moved.head<2>() / moved.z() - to).squaredNorm();
}

double LineDistance2(const Eigen::Vector3d& line, const Eigen::Vector2d& point) {
  const double value = line.dot(point.homogeneous());
  return value * value / line.head<2>().squaredNorm();
}

// Estimates from a sample in normalized coordinates and takes the result back to pixels.
class LinearEstimator {
 public:
  LinearEstimator(TwoViewModelKind kind, const Points& first, const Points& second)
      : kind_(kind),
        first_transform_(Normalization(first)),
        second_transform_(Normalization(second)),
        first_(Transform(first_transform_, first)),
        second_(Transform(second_transform_, second)) {}

  Eigen::Matrix3d Estimate(std::span<const int> sample) const {
    if (kind_ == TwoViewModelKind::kHomography) {
      return second_transform_.inverse() * LinearHomography(first_, second_, sample) * first_transform_;
    }
    return second_transform_.transpose() * LinearFundamental(first_, second_, sample) * first_transform_;
  }

 private:
  TwoViewModelKind kind_;
  Eigen::Matrix3d first_transform_;
  Eigen::Matrix3d second_transform_;
  Points first_;
  Points second_;
};

std::vector<int> InlierIndices(const TwoViewModel& model) {
  std::vector<int> indices;
  for (size_t i = 0; i < model.inlier.size(); ++i) {
    if (model.inlier[i]) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

}  // namespace

void ScoreTwoViewModel(TwoViewModelKind kind, const Points& first, const Points& second, double sigma_px,
                       TwoViewModel* model) {
  const bool is_homography = kind == TwoViewModelKind::kHomography;
  const double bound = is_homography ? kHomographyBound : kFundamentalBound;
  const double inverse_sigma2 = 1.0 / (sigma_px * sigma_px);
  const Eigen::Matrix3d forward = model->matrix;
  const Eigen::Matrix3d backward =
      is_homography ? Eigen::Matrix3d(forward.inverse()) : Eigen::Matrix3d(forward.transpose());
  model->score = 0;
  model->inliers = 0;
  model->inlier.assign(first.size(), 0);
  for (size_t i = 0; i < first.size(); ++i) {
    const double in_second =
        inverse_sigma2 * (is_homography ? TransferError2(forward, first[i], second[i])
                                        : LineDistance2(forward * first[i].homogeneous(), second[i]));
    const double in_first =
        inverse_sigma2 * (is_homography ? TransferError2(backward, second[i], first[i])
                                        : LineDistance2(backward * second[i].homogeneous(), first[i]));
    // Written so that not-a-number (a degenerate model) fails.
    if (in_second < bound) model->score += kGamma - in_second;
    if (in_first < bound) model->score += kGamma - in_first;
    model->inlier[i] = in_second < bound && in_first < bound ? 1 : 0;
    model->inliers += model->inlier[i];
  }
}

TwoViewModel EstimateTwoViewModel(TwoViewModelKind kind, const Points& first, const Points& second,
                                  const TwoViewRansacOptions& options, const TwoViewRefinement& refine) {
  TwoViewModel best;
  best.inlier.assign(first.size(), 0);
  if (first.size() < kMinMatches || first.size() != second.size()) return best;
  const int sample_size = kind == TwoViewModelKind::kHomography ? kHomographySample : kFundamentalSample;
  const LinearEstimator estimator(kind, first, second);
  Sampler sampler(first.size(), options.seed);
  TwoViewModel candidate;
  const auto try_matrix = [&](const Eigen::Matrix3d& matrix) {
    candidate.matrix = matrix;
    ScoreTwoViewModel(kind, first, second, options.sigma_px, &candidate);
    if (!(candidate.score > best.score)) return false;
    std::swap(best, candidate);
    return true;
  };
  int iterations = options.max_iterations;
  for (int i = 0; i < iterations; ++i) {
    if (!try_matrix(estimator.Estimate(sampler.Draw(sample_size)))) continue;
    for (int j = 0; j < kRefinements && best.inliers >= kMinMatches; ++j) {
      const bool linear = try_matrix(estimator.Estimate(InlierIndices(best)));
      const bool nonlinear = refine && try_matrix(refine(best));
      if (!linear && !nonlinear) break;
    }
    const double ratio = static_cast<double>(best.inliers) / static_cast<double>(first.size());
    iterations = RansacIterations(ratio, sample_size, kConfidence, options.max_iterations);
  }
  return best;
}

}  // namespace semmap
