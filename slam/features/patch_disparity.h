#pragma once

#include <cstdint>
#include <optional>

#include <opencv2/core/mat.hpp>

namespace semmap {

// Half side of the square patches that are compared, and how far to either side of the guess the best place
// is sought; pixels of the level.
constexpr int kPatchRadius = 5;
constexpr int kPatchSearch = 5;

struct PatchMatch {
  // Column in the right image, sub-pixel.
  float right_x = 0;
  // Sum of absolute differences at the best whole pixel.
  int score = 0;
};

// Finds the patch around (x, y) of `left` in the same row of `right`, near column `guess_x`, by the sum of
// absolute differences, then its column to about a twentieth of a pixel. Nothing if the patches do not fit
// into the images, or if the best place is at an end of the search range or hardly better than the others.
// Both images are padded (padded_image.h), as those of an OrbExtractor's pyramid are.
std::optional<PatchMatch> FindPatchInRow(const cv::Mat& left, const cv::Mat& right, int x, int y,
                                         int guess_x);

}  // namespace semmap
