#include "slam/features/smoothing.h"

#include <array>
#include <cstddef>

#include "slam/features/byte_vector.h"
#include "slam/features/padded_image.h"

namespace semmap {
namespace {

constexpr int kRadius = Smoother::kRadius;
constexpr int kTaps = 2 * kRadius + 1;
static_assert(ByteVector::kLanes <= kImagePadding);

using Taps = std::array<const uint8_t*, kTaps>;

// Weights 1 2 3 4 3 2 1: the mean of 1 0 2 2 2 0 1 and 0 2 1 2 1 2 0.
void AverageTaps(const Taps& taps, int count, uint8_t* to) {
  for (int x = 0; x < count; x += ByteVector::kLanes) {
    const auto tap = [&](int i) { return ByteVector::Load(taps[i] + x); };
    const ByteVector centre = tap(3);
    const ByteVector inner = Average(tap(2), tap(4));
    const ByteVector middle = Average(tap(1), tap(5));
    const ByteVector outer = Average(tap(0), tap(6));
    const ByteVector odd = Average(Average(outer, centre), inner);
    const ByteVector even = Average(middle, Average(inner, centre));
    Average(odd, even).Store(to + x);
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
  row_.resize(static_cast<size_t>(width) + 2 * kRadius + 2 * kImagePadding);
  uint8_t* row = row_.data() + kRadius;
  for (int y = 0; y < image.rows; ++y) {
    Taps taps;
    for (int i = 0; i < kTaps; ++i) taps[i] = image.ptr(Mirrored(y + i - kRadius, image.rows));
    AverageTaps(taps, width, row);
    for (int i = 1; i <= kRadius; ++i) {
      row[-i] = row[i];
      row[width - 1 + i] = row[width - 1 - i];
    }
    for (int i = 0; i < kTaps; ++i) taps[i] = row + i - kRadius;
    AverageTaps(taps, width, smooth->ptr(y));
  }
}

}  // namespace semmap
