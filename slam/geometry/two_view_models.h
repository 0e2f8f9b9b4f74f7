#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace semmap {

// A homography (second ~ H * first) or fundamental matrix (second^T F first = 0) between two images in
// pixels, with its support.
struct TwoViewModel {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  double score = 0;
  std::vector<char> inlier;
  int inliers = 0;
};

enum class TwoViewModelKind { kHomography, kFundamental };

struct TwoViewRansacOptions {
  double sigma_px = 1.0;
  // Upper bound; fewer once a sample free of outliers was drawn with near certainty.
  int max_iterations = 200;
  uint32_t seed = 0;
};

// Score and inliers of a model given in `model->matrix`: sum over both directions of Gamma - d^2 where d^2,
// the squared transfer error over sigma^2 (distance to the point for a homography, to the epipolar line for a
// fundamental matrix), is under its 95 % bound (Mur-Artal et al. 2015, equation 2).
void ScoreTwoViewModel(TwoViewModelKind kind, const std::vector<Eigen::Vector2d>& first,
                       const std::vector<Eigen::Vector2d>& second, double sigma_px, TwoViewModel* model);

// A better matrix for the inliers of a model, or any matrix: it is taken only if its score is higher.
using TwoViewRefinement = std::function<Eigen::Matrix3d(const TwoViewModel&)>;

// RANSAC over normalized direct linear transforms (Hartley and Zisserman, algorithms 4.2 and 11.1), each new
// best model being estimated again from its inliers, by the linear method and then by `refine` (may be
// empty). Needs at least 8 matches, else the score is 0. Deterministic.
TwoViewModel EstimateTwoViewModel(TwoViewModelKind kind, const std::vector<Eigen::Vector2d>& first,
                                  const std::vector<Eigen::Vector2d>& second,
                                  const TwoViewRansacOptions& options, const TwoViewRefinement& refine);

}  // namespace semmap
