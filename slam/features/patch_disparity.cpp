#include "slam/features/patch_disparity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace semmap {
namespace {

constexpr int kSide = 2 * kPatchRadius + 1;
constexpr int kShifts = 2 * kPatchSearch + 1;
// A row of a patch is read as 16 bytes, of which the first kSide count.
constexpr int kLanes = 16;
static_assert(kSide <= kLanes);

// How bad, against the mean over the search range, the best place may be.
constexpr float kMaxShareOfMean = 0.75F;

using Scores = std::array<int, kShifts>;

// Sums of absolute differences of the patch at `left` with those at right, right + 1, ...
#ifdef __SSE2__
Scores CompareShifted(const uint8_t* left, ptrdiff_t left_step, const uint8_t* right, ptrdiff_t right_step) {
  alignas(16) static constexpr uint8_t kMask[kLanes] = {255, 255, 255, 255, 255, 255,
                                                        255, 255, 255, 255, 255};
  const __m128i mask = _mm_load_si128(reinterpret_cast<const __m128i*>(kMask));
  __m128i sums[kShifts];
  for (__m128i& sum : sums) sum = _mm_setzero_si128();
  for (int row = 0; row < kSide; ++row, left += left_step, right += right_step) {
    const __m128i reference = _mm_and_si128(_mm_loadu_si128(reinterpret_cast<const __m128i*>(left)), mask);
    for (int shift = 0; shift < kShifts; ++shift) {
      const __m128i candidate = _mm_loadu_si128(reinterpret_cast<const __m128i*>(right + shift));
      sums[shift] = _mm_add_epi32(sums[shift], _mm_sad_epu8(reference, _mm_and_si128(candidate, mask)));
    }
  }
  Scores scores;
  for (int shift = 0; shift < kShifts; ++shift) {
    scores[shift] = _mm_cvtsi128_si32(_mm_add_epi32(sums[shift], _mm_srli_si128(sums[shift], 8)));
  }
  return scores;
}
#else
Scores CompareShifted(const uint8_t* left, ptrdiff_t left_step, const uint8_t* right, ptrdiff_t right_step) {
  Scores scores{};
  for (int row = 0; row < kSide; ++row, left += left_step, right += right_step) {
    for (int shift = 0; shift < kShifts; ++shift) {
      for (int column = 0; column < kSide; ++column)
        scores[shift] += std::abs(left[column] - right[shift + column]);
    }
  }
  return scores;
}
#endif

bool PatchFits(const cv::Mat& image, int x, int y, int reach) {
  return x >= reach && x < image.cols - reach && y >= kPatchRadius && y < image.rows - kPatchRadius;
}

// Where a parabola through three equidistant values has its minimum, relative to the middle one, which is the
// least.
float ParabolaMinimum(int before, int middle, int after) {
  const int curvature = before - 2 * middle + after;
  if (curvature <= 0) return 0;
  return 0.5F * static_cast<float>(before - after) / static_cast<float>(curvature);
}

}  // namespace

std::optional<PatchMatch> FindPatchInRow(const cv::Mat& left, const cv::Mat& right, int x, int y,
                                         int guess_x) {
  if (!PatchFits(left, x, y, kPatchRadius) || !PatchFits(right, guess_x, y, kPatchRadius + kPatchSearch))
    return {};
  const int top = y - kPatchRadius;
  const Scores scores = CompareShifted(left.ptr(top, x - kPatchRadius), static_cast<ptrdiff_t>(left.step[0]),
                                       right.ptr(top, guess_x - kPatchRadius - kPatchSearch),
                                       static_cast<ptrdiff_t>(right.step[0]));
  const int best = static_cast<int>(std::min_element(scores.begin(), scores.end()) - scores.begin());
  if (best == 0 || best == kShifts - 1) return {};
  // Along a horizontal edge, or between different things, no place is much better than the others.
  const int sum = std::accumulate(scores.begin(), scores.end(), 0);
  if (static_cast<float>(scores[best] * kShifts) > kMaxShareOfMean * static_cast<float>(sum)) return {};
  const float offset = ParabolaMinimum(scores[best - 1], scores[best], scores[best + 1]);
  return PatchMatch{static_cast<float>(guess_x + best - kPatchSearch) + offset, scores[best]};
}

}  // namespace semmap
