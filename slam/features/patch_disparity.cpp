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
constexpr int kRowWidth = 16;
static_assert(kSide <= kRowWidth);

// How bad, against the mean over the search range, the best place may be.
constexpr float kMaxShareOfMean = 0.75F;

// A step that leaves the best pixel this far behind has failed.
constexpr float kMaxOffset = 1;

using Scores = std::array<int, kShifts>;

// Sums of absolute differences of the patch at `left` with those at right, right + 1, ...
#ifdef __SSE2__
Scores CompareShifted(const uint8_t* left, ptrdiff_t left_step, const uint8_t* right, ptrdiff_t right_step) {
  alignas(16) static constexpr uint8_t kMask[kRowWidth] = {255, 255, 255, 255, 255, 255,
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

// One pixel more than the reach is for gradients.
bool PatchFits(const cv::Mat& image, int x, int y, int reach) {
  return x > reach && x < image.cols - reach - 1 && y >= kPatchRadius && y < image.rows - kPatchRadius;
}

// Where the minimum lies between the pixels, relative to `middle`, the least of three neighbouring scores:
// two lines of opposite slopes through them meet there (Shimizu and Okutomi, IJCV 2005). Sums of absolute
// differences look like that; a parabola would draw the result to whole pixels, by a tenth of one.
float MeetingOfLines(int before, int middle, int after) {
  const int rise = std::max(before, after) - middle;
  return rise > 0 ? 0.5F * static_cast<float>(before - after) / static_cast<float>(rise) : 0.0F;
}

// Normal equation of a shift along the row, kept for each column apart so that it vectorizes; only kSide
// columns count.
struct ShiftEquation {
  using Columns = std::array<float, kRowWidth>;
  Columns error_gradient{};
  Columns gradient_gradient{};
  Columns error{};
  Columns gradient{};

  // `left` and `right` are at the first pixel of a row; the right patch is `fraction` of a pixel further.
  void AddRow(const uint8_t* left, const uint8_t* right, float fraction) {
    std::array<float, kRowWidth + 2> shifted;
    for (int i = 0; i < kRowWidth + 2; ++i) {
      const auto first = static_cast<float>(right[i - 1]);
      shifted[i] = first + fraction * (static_cast<float>(right[i]) - first);
    }
    for (int i = 0; i < kRowWidth; ++i) {
      const float e = static_cast<float>(left[i]) - shifted[i + 1];
      const float g = static_cast<float>(left[i + 1] - left[i - 1]) + shifted[i + 2] - shifted[i];
      error_gradient[i] += e * g;
      gradient_gradient[i] += g * g;
      error[i] += e;
      gradient[i] += g;
    }
  }

  // How much further to the right in `right` the patch is found, a difference of brightness aside.
  float Solve() const {
    const auto sum = [](const Columns& columns) {
      return std::accumulate(columns.begin(), columns.begin() + kSide, 0.0F);
    };
    const float mean_gradient = sum(gradient) / (kSide * kSide);
    const float numerator = sum(error_gradient) - sum(error) * mean_gradient;
    const float denominator = sum(gradient_gradient) - sum(gradient) * mean_gradient;
    // The gradients are sums of two central differences, four times the slope.
    return denominator > 1.0F ? 4.0F * numerator / denominator : 0.0F;
  }
};

// One Gauss-Newton step with the mean gradient of both patches (Malis, ICRA 2004) from `offset` pixels after
// `right_x`.
float RefineOffset(const cv::Mat& left, const cv::Mat& right, int left_x, int right_x, int top,
                   float offset) {
  const float whole = std::floor(offset);
  right_x += static_cast<int>(whole);
  ShiftEquation equation;
  for (int y = top; y < top + kSide; ++y) {
    equation.AddRow(left.ptr(y, left_x), right.ptr(y, right_x), offset - whole);
  }
  return offset + equation.Solve();
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
  const int right_x = guess_x + best - kPatchSearch;
  const float between = MeetingOfLines(scores[best - 1], scores[best], scores[best + 1]);
  const float offset = RefineOffset(left, right, x - kPatchRadius, right_x - kPatchRadius, top, between);
  if (std::abs(offset) > kMaxOffset) return {};
  return PatchMatch{static_cast<float>(right_x) + offset, scores[best]};
}

}  // namespace semmap
