#include "slam/geometry/two_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "slam/geometry/essential.h"
#include "slam/geometry/triangulation.h"
#include "slam/geometry/two_view_models.h"

namespace semmap {
namespace {

// Share of the homography in the sum of both scores from which the scene counts as planar or the parallax as
// low.
constexpr double kHomographyRatio = 0.45;
// 95 % quantile of chi^2 with two degrees of freedom, for the reprojection error of a triangulated point.
constexpr double kReprojectionBound = 5.991;
// The runner-up may have at most this share of the winner's points.
constexpr double kMaxRunnerUp = 0.75;
// The winner must explain at least this share of the model's inliers.
constexpr double kMinGoodShare = 0.5;
// A point counts as good from this share of the demanded median parallax on; below it, its depth is noise.
constexpr double kPointParallaxShare = 0.3;

Eigen::Matrix3d CameraMatrix(const CameraIntrinsics& camera) {
  Eigen::Matrix3d matrix;
  matrix << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return matrix;
}

// OpenCV's decomposition (Malis and Vargas 2007) gives the solutions with opposite translation too.
std::vector<SE3> MotionsOfHomography(const Eigen::Matrix3d& homography,
                                     const Eigen::Matrix3d& camera_matrix) {
  std::vector<SE3> motions;
  try {
    cv::Matx33d cv_homography;
    cv::Matx33d cv_camera;
    cv::eigen2cv(homography, cv_homography);
    cv::eigen2cv(camera_matrix, cv_camera);
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    std::vector<cv::Mat> normals;
    cv::decomposeHomographyMat(cv_homography, cv_camera, rotations, translations, normals);
    for (size_t i = 0; i < rotations.size(); ++i) {
      Eigen::Matrix3d rotation;
      Eigen::Vector3d translation;
      cv::cv2eigen(rotations[i], rotation);
      cv::cv2eigen(translations[i], translation);
      if (translation.norm() > 0 && rotation.allFinite())
        motions.emplace_back(rotation, translation.normalized());
    }
  } catch (const cv::Exception&) {
    motions.clear();  // a singular homography has no motion
  }
  return motions;
}

class MotionChecker {
 public:
  MotionChecker(const CameraIntrinsics& camera, const std::vector<Eigen::Vector2d>& first,
                const std::vector<Eigen::Vector2d>& second, const TwoViewOptions& options)
      : camera_(camera), first_(first), second_(second), options_(options) {}

  // Triangulates the model's inliers and keeps those that both cameras see in front of them, where they were
  // seen, and under enough of an angle.
  TwoViewReconstruction Check(const SE3& second_from_first, const TwoViewModel& model) const {
    TwoViewReconstruction result;
    result.second_from_first = second_from_first;
    result.points_in_first.resize(first_.size());
    std::vector<double> parallaxes;
    for (size_t i = 0; i < first_.size(); ++i) {
      if (!model.inlier[i]) continue;
      const auto point = GoodPoint(second_from_first, first_[i], second_[i]);
      if (!point) continue;
      const double parallax = Parallax(second_from_first, *point);
      if (parallax < kPointParallaxShare * options_.min_parallax_rad) continue;
      result.points_in_first[i] = point;
      parallaxes.push_back(parallax);
    }
    result.good_points = static_cast<int>(parallaxes.size());
    result.median_parallax_rad = Median(&parallaxes);
    return result;
  }

 private:
  std::optional<Eigen::Vector3d> GoodPoint(const SE3& second_from_first, const Eigen::Vector2d& first,
                                           const Eigen::Vector2d& second) const {
    const auto point =
        TriangulateLinear(SE3(), second_from_first, RayOfPixel(camera_, first), RayOfPixel(camera_, second));
    if (!point || !Reprojects(*point, first) || !Reprojects(second_from_first * *point, second)) {
      return std::nullopt;
    }
    return point;
  }

  bool Reprojects(const Eigen::Vector3d& point_in_camera, const Eigen::Vector2d& pixel) const {
    if (!(point_in_camera.z() > 0)) return false;
    const double error2 = (ProjectPinhole(camera_, point_in_camera) - pixel).squaredNorm();
    return error2 < kReprojectionBound * options_.sigma_px * options_.sigma_px;
  }

  // Angle between the directions from the point to both cameras.
  static double Parallax(const SE3& second_from_first, const Eigen::Vector3d& point_in_first) {
    const Eigen::Vector3d from_second = point_in_first - second_from_first.Inverse().translation();
    return std::atan2(point_in_first.cross(from_second).norm(), point_in_first.dot(from_second));
  }

  static double Median(std::vector<double>* values) {
    if (values->empty()) return 0;
    const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
    std::nth_element(values->begin(), middle, values->end());
    return *middle;
  }

  const CameraIntrinsics& camera_;
  const std::vector<Eigen::Vector2d>& first_;
  const std::vector<Eigen::Vector2d>& second_;
  const TwoViewOptions& options_;
};

// The motion with clearly the most good points, if they are enough.
std::optional<TwoViewReconstruction> SelectMotion(const MotionChecker& checker,
                                                  const std::vector<SE3>& motions, const TwoViewModel& model,
                                                  const TwoViewOptions& options) {
  TwoViewReconstruction best;
  int runner_up = 0;
  for (const SE3& motion : motions) {
    TwoViewReconstruction candidate = checker.Check(motion, model);
    if (candidate.good_points > best.good_points) std::swap(best, candidate);
    runner_up = std::max(runner_up, candidate.good_points);
  }
  const bool enough =
      best.good_points >= options.min_good_points && best.good_points >= kMinGoodShare * model.inliers;
  const bool clear = runner_up <= kMaxRunnerUp * best.good_points;
  if (!enough || !clear || best.median_parallax_rad < options.min_parallax_rad) return std::nullopt;
  return best;
}

std::vector<Eigen::Vector3d> Rays(const CameraIntrinsics& camera,
                                  const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) rays.push_back(RayOfPixel(camera, pixel));
  return rays;
}

// A fundamental matrix of a calibrated camera has five degrees of freedom; the linear method fits seven, and
// with them more of the noise than a motion taken from it endures.
TwoViewModel EstimateCalibratedFundamental(const Eigen::Matrix3d& camera_matrix,
                                           const CameraIntrinsics& camera,
                                           const std::vector<Eigen::Vector2d>& first,
                                           const std::vector<Eigen::Vector2d>& second,
                                           const TwoViewRansacOptions& options) {
  const std::vector<Eigen::Vector3d> first_rays = Rays(camera, first);
  const std::vector<Eigen::Vector3d> second_rays = Rays(camera, second);
  const Eigen::Matrix3d inverse = camera_matrix.inverse();
  const auto refine = [&](const TwoViewModel& model) -> Eigen::Matrix3d {
    const Eigen::Matrix3d essential = camera_matrix.transpose() * model.matrix * camera_matrix;
    const double sigma = options.sigma_px / camera.fx;
    return inverse.transpose() * RefineEssential(essential, first_rays, second_rays, model.inlier, sigma) *
           inverse;
  };
  TwoViewModel model = EstimateTwoViewModel(TwoViewModelKind::kFundamental, first, second, options, refine);
  // The best score may be a linear model's; what follows needs one with a motion behind it.
  model.matrix = refine(model);
  ScoreTwoViewModel(TwoViewModelKind::kFundamental, first, second, options.sigma_px, &model);
  return model;
}

}  // namespace

std::optional<TwoViewReconstruction> ReconstructTwoViews(const CameraIntrinsics& camera,
                                                         const std::vector<Eigen::Vector2d>& first,
                                                         const std::vector<Eigen::Vector2d>& second,
                                                         const TwoViewOptions& options) {
  const TwoViewRansacOptions ransac = {options.sigma_px, options.iterations, options.seed};
  const Eigen::Matrix3d k = CameraMatrix(camera);
  const TwoViewModel homography =
      EstimateTwoViewModel(TwoViewModelKind::kHomography, first, second, ransac, nullptr);
  const TwoViewModel fundamental = EstimateCalibratedFundamental(k, camera, first, second, ransac);
  const double sum = homography.score + fundamental.score;
  if (!(sum > 0)) return std::nullopt;
  const MotionChecker checker(camera, first, second, options);
  const bool planar = homography.score > kHomographyRatio * sum;
  auto result = planar ? SelectMotion(checker, MotionsOfHomography(homography.matrix, k), homography, options)
                       : SelectMotion(checker, MotionsOfEssential(k.transpose() * fundamental.matrix * k),
                                      fundamental, options);
  if (result) result->from_homography = planar;
  return result;
}

}  // namespace semmap
