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
// The runner-up may have at most this share of the winner's consistent matches.
constexpr double kMaxRunnerUp = 0.85;
// The winner must explain at least this share of the model's inliers.
constexpr double kMinConsistentShare = 0.75;
// A point counts as good from a parallax of this many standard deviations of a ray on; below, its depth is
// noise.
constexpr double kMinParallaxSigmas = 4;

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

struct CheckedMotion {
  TwoViewReconstruction reconstruction;
  // Matches that the motion explains, also those so far away that they are not good points. Motions are
  // compared by these: a wrong motion often has the larger parallaxes, and so the more good points.
  int consistent = 0;
};

class MotionChecker {
 public:
  MotionChecker(const CameraIntrinsics& camera, const std::vector<Eigen::Vector2d>& first,
                const std::vector<Eigen::Vector2d>& second, const TwoViewOptions& options)
      : camera_(camera), first_(first), second_(second), options_(options) {}

  // Triangulates the model's inliers and keeps those that both cameras see in front of them, where they were
  // seen, and under enough of an angle.
  CheckedMotion Check(const SE3& second_from_first, const TwoViewModel& model) const {
    CheckedMotion checked;
    TwoViewReconstruction& result = checked.reconstruction;
    result.second_from_first = second_from_first;
    result.points_in_first.resize(first_.size());
    std::vector<double> parallaxes;
    for (size_t i = 0; i < first_.size(); ++i) {
      if (!model.inlier[i]) continue;
      const auto point = ConsistentPoint(second_from_first, first_[i], second_[i]);
      if (point || IsAtInfinity(second_from_first, first_[i], second_[i])) ++checked.consistent;
      if (!point) continue;
      const double parallax = Parallax(second_from_first, *point);
      if (parallax < kMinParallaxSigmas * options_.sigma_px / camera_.fx) continue;
      result.points_in_first[i] = point;
      parallaxes.push_back(parallax);
    }
    result.good_points = static_cast<int>(parallaxes.size());
    result.median_parallax_rad = Median(&parallaxes);
    return checked;
  }

 private:
  std::optional<Eigen::Vector3d> ConsistentPoint(const SE3& second_from_first, const Eigen::Vector2d& first,
                                                 const Eigen::Vector2d& second) const {
    const auto point =
        TriangulateLinear(SE3(), second_from_first, RayOfPixel(camera_, first), RayOfPixel(camera_, second));
    if (!point || !Reprojects(*point, first) || !Reprojects(second_from_first * *point, second)) {
      return std::nullopt;
    }
    return point;
  }

  // Whether rotation alone explains the match, so that the sign of its depth means nothing.
  bool IsAtInfinity(const SE3& second_from_first, const Eigen::Vector2d& first,
                    const Eigen::Vector2d& second) const {
    return Reprojects(second_from_first.rotation() * RayOfPixel(camera_, first), second);
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

// The motion with clearly the most consistent matches, if enough of them are good points.
std::optional<TwoViewReconstruction> SelectMotion(const MotionChecker& checker,
                                                  const std::vector<SE3>& motions, const TwoViewModel& model,
                                                  const TwoViewOptions& options) {
  CheckedMotion best;
  int runner_up = 0;
  for (const SE3& motion : motions) {
    CheckedMotion candidate = checker.Check(motion, model);
    if (candidate.consistent > best.consistent) std::swap(best, candidate);
    runner_up = std::max(runner_up, candidate.consistent);
  }
  const TwoViewReconstruction& result = best.reconstruction;
  const bool enough =
      result.good_points >= options.min_good_points && best.consistent >= kMinConsistentShare * model.inliers;
  const bool clear = runner_up <= kMaxRunnerUp * best.consistent;
  if (!enough || !clear || result.median_parallax_rad < options.min_parallax_rad) return std::nullopt;
  return std::move(best.reconstruction);
}

std::vector<Eigen::Vector3d> Rays(const CameraIntrinsics& camera,
                                  const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) rays.push_back(RayOfPixel(camera, pixel));
  return rays;
}

// A fundamental matrix of a calibrated camera has five degrees of freedom; the linear method fits seven, and
// with them more of the noise than a motion taken from it endures. So essential matrices are fitted in its
// place.
class CalibratedEstimator {
 public:
  CalibratedEstimator(const CameraIntrinsics& camera, const std::vector<Eigen::Vector2d>& first,
                      const std::vector<Eigen::Vector2d>& second, const TwoViewRansacOptions& options)
      : camera_matrix_(CameraMatrix(camera)),
        inverse_(camera_matrix_.inverse()),
        first_(first),
        second_(second),
        first_rays_(Rays(camera, first)),
        second_rays_(Rays(camera, second)),
        options_(options),
        ray_sigma_(options.sigma_px / camera.fx) {}

  TwoViewModel Estimate() const {
    const auto refine = [this](const TwoViewModel& model) -> Eigen::Matrix3d {
      return Refined(EssentialOf(model), model.inlier).matrix;
    };
    const TwoViewModel linear =
        EstimateTwoViewModel(TwoViewModelKind::kFundamental, first_, second_, options_, refine);
    // The best score may be a linear model's; what follows needs one with a motion behind it.
    TwoViewModel best = Refined(EssentialOf(linear), linear.inlier);
    for (const Eigen::Matrix3d& start : OtherStarts(linear)) {
      TwoViewModel candidate = Refined(start, WideInliers(linear));
      if (candidate.score > best.score) best = std::move(candidate);
    }
    return Refined(EssentialOf(best), best.inlier);
  }

  Eigen::Matrix3d EssentialOf(const TwoViewModel& model) const {
    return camera_matrix_.transpose() * model.matrix * camera_matrix_;
  }

 private:
  TwoViewModel Refined(const Eigen::Matrix3d& essential, const std::vector<char>& use) const {
    TwoViewModel model;
    model.matrix = inverse_.transpose() *
                   RefineEssential(essential, first_rays_, second_rays_, use, ray_sigma_) * inverse_;
    ScoreTwoViewModel(TwoViewModelKind::kFundamental, first_, second_, options_.sigma_px, &model);
    return model;
  }

  // Also what the model misses by little: between two minima, those matches decide.
  std::vector<char> WideInliers(TwoViewModel model) const {
    ScoreTwoViewModel(TwoViewModelKind::kFundamental, first_, second_, kWideSigmas * options_.sigma_px,
                      &model);
    return std::move(model.inlier);
  }

  // With small motions the error has several minima, one for each way in which rotation can stand in for
  // translation, and samples of eight mostly lead to the wide wrong ones. So the search also starts from the
  // rotation that explains the matches best alone, with translations all around.
  std::vector<Eigen::Matrix3d> OtherStarts(const TwoViewModel& model) const {
    const Eigen::Quaterniond rotation = BestRotation(first_rays_, second_rays_, model.inlier);
    std::vector<Eigen::Matrix3d> starts;
    for (const auto& direction : kStartDirections) {
      const Eigen::Vector3d translation =
          Eigen::Vector3d(direction[0], direction[1], direction[2]).normalized();
      starts.push_back(EssentialOfMotion(SE3(rotation, translation)));
    }
    return starts;
  }

  static constexpr double kWideSigmas = 3;
  static constexpr double kStartDirections[9][3] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 0, 1}, {1, 0, -1},
                                                    {0, 1, 1}, {0, 1, -1}, {1, 1, 0}, {1, -1, 0}};

  Eigen::Matrix3d camera_matrix_;
  Eigen::Matrix3d inverse_;
  const std::vector<Eigen::Vector2d>& first_;
  const std::vector<Eigen::Vector2d>& second_;
  std::vector<Eigen::Vector3d> first_rays_;
  std::vector<Eigen::Vector3d> second_rays_;
  TwoViewRansacOptions options_;
  double ray_sigma_;
};

}  // namespace

std::optional<TwoViewReconstruction> ReconstructTwoViews(const CameraIntrinsics& camera,
                                                         const std::vector<Eigen::Vector2d>& first,
                                                         const std::vector<Eigen::Vector2d>& second,
                                                         const TwoViewOptions& options) {
  const TwoViewRansacOptions ransac = {options.sigma_px, options.iterations, options.seed};
  const TwoViewModel homography =
      EstimateTwoViewModel(TwoViewModelKind::kHomography, first, second, ransac, nullptr);
  if (homography.inliers == 0) return std::nullopt;
  const CalibratedEstimator calibrated(camera, first, second, ransac);
  const TwoViewModel fundamental = calibrated.Estimate();
  const double sum = homography.score + fundamental.score;
  const MotionChecker checker(camera, first, second, options);
  const bool planar = homography.score > kHomographyRatio * sum;
  auto result = planar ? SelectMotion(checker, MotionsOfHomography(homography.matrix, CameraMatrix(camera)),
                                      homography, options)
                       : SelectMotion(checker, MotionsOfEssential(calibrated.EssentialOf(fundamental)),
                                      fundamental, options);
  if (result) result->from_homography = planar;
  return result;
}

}  // namespace semmap
