#include "slam/features/smoothing.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace semmap {
namespace {

constexpr int kRadius = Smoother::kRadius;
constexpr int kTaps = 2 * kRadius + 1;
// exp(-d^2 / 8) for d = 0 to 3, scaled so that the seven weights sum to 256.
constexpr std::array<uint16_t, kRadius + 1> kWeights = {54, 49, 34, 18};
static_assert(kWeights[0] + 2 * (kWeights[1] + kWeights[2] + kWeights[3]) == 256);

using Taps = std::array<const uint8_t*, kTaps>;

// to[x] = sum of weights[i] * taps[i][x], rounded. The sum fits 16 bits, which doubles the pixels in a
// vector.
void WeighTaps(const Taps& taps, int count, uint8_t* __restrict to) {
  for (int x = 0; x < count; ++x) {
    const auto sum = static_cast<uint16_t>(
        kWeights[0] * taps[3][x] + kWeights[1] * (taps[2][x] + taps[4][x]) +
        kWeights[2] * (taps[1][x] + taps[5][x]) + kWeights[3] * (taps[0][x] + taps[6][x]) + 128);
    to[x] = static_cast<uint8_t>(sum >> 8);
  }
}

// Index of a row mirrored at the first and last one.
int Mirrored(int i, int count) {
  if (i < 0) return -i;
  return i < count ? i : 2 * (count - 1) - i;
}

}  // namespace

void Smoother::Smooth(const cv::Mat& image, cv::Mat* smooth) {
  const int width = image.cols;
  row_.resize(static_cast<size_t>(width) + 2 * kRadius);
  uint8_t* row = row_.data() + kRadius;
  for (int y = 0; y < image.rows; ++y) {
    Taps taps;
    for (int i = 0; i < kTaps; ++i) taps[i] = image.ptr(Mirrored(y + i - kRadius, image.rows));
    WeighTaps(taps, width, row);
    for (int i = 1; i <= kRadius; ++i) {
      row[-i] = row[i];
      row[width - 1 + i] = row[width - 1 - i];
    }
    for (int i = 0; i < kTaps; ++i) taps[i] = row + i - kRadius;
    WeighTaps(taps, width, smooth->ptr(y));
  }
}

}  // namespace semmap
