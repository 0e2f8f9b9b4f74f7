#pragma once

#include <vector>

#include <Eigen/Core>

#include "slam/geometry/se3.h"

namespace semmap {

// Matches as viewing rays with z = 1: second[i]^T E first[i] = 0 for an essential matrix E = [t]x R, where
// (R, t) is second_from_first.

// Both twists and both directions of the unit translation that an essential matrix allows (Hartley and
// Zisserman, result 9.19). Any 3x3 matrix is taken for the nearest essential one.
std::vector<SE3> MotionsOfEssential(const Eigen::Matrix3d& essential);

Eigen::Matrix3d EssentialOfMotion(const SE3& second_from_first);

// The rotation that turns the rays with use[i] != 0 onto their matches best, in the least squares of unit
// vectors.
Eigen::Quaterniond BestRotation(const std::vector<Eigen::Vector3d>& first,
                                const std::vector<Eigen::Vector3d>& second, const std::vector<char>& use);

// Minimizes the Huber-robust Sampson error (Hartley and Zisserman, 11.4.3) of the matches with use[i] != 0
// over the five degrees of freedom of an essential matrix, from the one nearest to `initial`. `sigma` is the
// standard deviation of a ray's coordinates.
Eigen::Matrix3d RefineEssential(const Eigen::Matrix3d& initial, const std::vector<Eigen::Vector3d>& first,
                                const std::vector<Eigen::Vector3d>& second, const std::vector<char>& use,
                                double sigma);

}  // namespace semmap
