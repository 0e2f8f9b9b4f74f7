#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace semmap {

// Draws samples without repetition, the same on every platform for one seed (std::uniform_int_distribution's
// numbers differ between standard libraries).
class Sampler {
 public:
  Sampler(size_t population, uint32_t seed) : indices_(population), random_(seed) {
    for (size_t i = 0; i < population; ++i) indices_[i] = static_cast<int>(i);
  }

  // `count` different indices below the population's size, which it must not exceed. Valid until the next
  // call.
  std::span<const int> Draw(size_t count) {
    // The beginning of Fisher and Yates' shuffle.
    for (size_t i = 0; i < count; ++i)
      std::swap(indices_[i], indices_[i + random_() % (indices_.size() - i)]);
    return std::span(indices_).first(count);
  }

 private:
  std::vector<int> indices_;
  std::mt19937 random_;
};

// How many samples RANSAC must draw to have one free of outliers with the given confidence, given the share
// of inliers; at most max_iterations.
inline int RansacIterations(double inlier_ratio, int sample_size, double confidence, int max_iterations) {
  const double good_sample = std::pow(inlier_ratio, sample_size);
  if (good_sample >= 1) return 1;
  const double needed = std::log(1 - confidence) / std::log1p(-good_sample);
  return needed < max_iterations ? static_cast<int>(std::ceil(needed)) : max_iterations;
}

}  // namespace semmap
