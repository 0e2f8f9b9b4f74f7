#include "slam/geometry/pnp.h"

#include <algorithm>
#include <utility>

#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "slam/geometry/sampling.h"

namespace semmap {
namespace {

constexpr size_t kSampleSize = 3;
constexpr size_t kPointsOfSolution = 4;
constexpr int kPoseRefinements = 5;

SE3 PoseOf(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  Eigen::Vector3d omega;
  Eigen::Vector3d t;
  cv::cv2eigen(rotation_vector, omega);
  cv::cv2eigen(translation, t);
  return {ExpSO3(omega), t};
}

class PnpRansac {
 public:
  PnpRansac(const CameraIntrinsics& camera, std::span<const Eigen::Vector3d> points,
            std::span<const Eigen::Vector2d> pixels, const PnpOptions& options)
      : camera_(camera),
        points_(points),
        pixels_(pixels),
        options_(options),
        camera_matrix_(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1) {}

  std::optional<PnpResult> Run() {
    Sampler sampler(points_.size(), options_.seed);
    int iterations = options_.max_iterations;
    for (int i = 0; i < iterations; ++i) {
      bool better = false;
      for (const SE3& pose : SolveMinimal(sampler.Draw(kSampleSize))) better = Try(pose) || better;
      if (!better) continue;
      const double ratio = static_cast<double>(best_.inliers) / static_cast<double>(points_.size());
      iterations = RansacIterations(ratio, kSampleSize, options_.confidence, options_.max_iterations);
    }
    for (int i = 0; i < kPoseRefinements && best_.inliers >= static_cast<int>(kPointsOfSolution); ++i) {
      if (!Try(RefineOnInliers())) break;
    }
    if (best_.inliers < options_.min_inliers) return std::nullopt;
    return best_;
  }

 private:
  void Gather(size_t i, std::vector<cv::Point3d>* points, std::vector<cv::Point2d>* pixels) const {
    points->emplace_back(points_[i].x(), points_[i].y(), points_[i].z());
    pixels->emplace_back(pixels_[i].x(), pixels_[i].y());
  }

  // Up to four poses that see the three points exactly where they were seen.
  std::vector<SE3> SolveMinimal(std::span<const int> sample) const {
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (const int i : sample) Gather(i, &points, &pixels);
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    cv::solveP3P(points, pixels, camera_matrix_, cv::noArray(), rotations, translations, cv::SOLVEPNP_AP3P);
    std::vector<SE3> poses;
    for (size_t i = 0; i < rotations.size(); ++i) poses.push_back(PoseOf(rotations[i], translations[i]));
    return poses;
  }

  SE3 RefineOnInliers() const {
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (size_t i = 0; i < points_.size(); ++i) {
      if (best_.inlier[i]) Gather(i, &points, &pixels);
    }
    const Eigen::AngleAxisd angle_axis(best_.camera_from_map.rotation());
    const Eigen::Vector3d omega = angle_axis.angle() * angle_axis.axis();
    cv::Mat rotation_vector;
    cv::Mat translation;
    cv::eigen2cv(omega, rotation_vector);
    cv::eigen2cv(best_.camera_from_map.translation(), translation);
    cv::solvePnPRefineLM(points, pixels, camera_matrix_, cv::noArray(), rotation_vector, translation);
    return PoseOf(rotation_vector, translation);
  }

  // Takes the pose for the best if it is better.
  bool Try(const SE3& pose) {
    if (!pose.IsFinite()) return false;
    const double bound = options_.max_error_px * options_.max_error_px;
    candidate_.camera_from_map = pose;
    candidate_.inliers = 0;
    candidate_.inlier.assign(points_.size(), 0);
    double score = 0;
    for (size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d point = pose * points_[i];
      if (!(point.z() > 0)) continue;
      const double error2 = (ProjectPinhole(camera_, point) - pixels_[i]).squaredNorm();
      if (!(error2 < bound)) continue;
      candidate_.inlier[i] = 1;
      ++candidate_.inliers;
      score += bound - error2;
    }
    if (!(score > best_score_)) return false;
    best_score_ = score;
    std::swap(best_, candidate_);
    return true;
  }

  const CameraIntrinsics& camera_;
  std::span<const Eigen::Vector3d> points_;
  std::span<const Eigen::Vector2d> pixels_;
  const PnpOptions& options_;
  cv::Matx33d camera_matrix_;
  PnpResult best_;
  PnpResult candidate_;
  double best_score_ = 0;
};

}  // namespace

std::optional<PnpResult> EstimatePose(const CameraIntrinsics& camera,
                                      std::span<const Eigen::Vector3d> points_in_map,
                                      std::span<const Eigen::Vector2d> undistorted_pixels,
                                      const PnpOptions& options) {
  if (points_in_map.size() != undistorted_pixels.size() || points_in_map.size() < kPointsOfSolution) {
    return std::nullopt;
  }
  try {
    return PnpRansac(camera, points_in_map, undistorted_pixels, options).Run();
  } catch (const cv::Exception&) {
    return std::nullopt;  // input that OpenCV cannot digest has no pose
  }
}

}  // namespace semmap
