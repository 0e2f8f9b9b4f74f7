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
// absolute differences, and refines its column below a pixel. Nothing if the patches do not fit into the
// images, or if the best place is at an end of the search range and so no minimum. Both images are levels of
// an OrbExtractor's pyramid, which may be read a few bytes past the end of a row.
std::optional<PatchMatch> FindPatchInRow(const cv::Mat& left, const cv::Mat& right, int x, int y,
                                         int guess_x);

}  // namespace semmap
