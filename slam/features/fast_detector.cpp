#include "slam/features/fast_detector.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "slam/features/byte_vector.h"

namespace semmap {
namespace {

constexpr int kCircle = 16;
// Score rows begin after this many zero bytes, so that the first pixel has a left neighbour.
constexpr int kLead = 64;
constexpr int kLanes = ByteVector::kLanes;
static_assert(kLanes <= FastDetector::kOverread && kLanes <= kLead);

// Byte offsets of the circle's pixels, clockwise from the top.
std::array<ptrdiff_t, kCircle> CircleOffsets(ptrdiff_t step) {
  constexpr int kX[kCircle] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
  constexpr int kY[kCircle] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
  std::array<ptrdiff_t, kCircle> offsets;
  for (int i = 0; i < kCircle; ++i) offsets[i] = kY[i] * step + kX[i];
  return offsets;
}

// The greatest, over all arcs of nine pixels, of the least difference on the arc. Two arcs that begin at
// neighbouring pixels share eight: best of both = min(shared eight, max(one end, other end)).
inline ByteVector BestArc(const ByteVector (&difference)[kCircle]) {
  ByteVector pairs[kCircle / 2] = {ByteVector::Zero(), ByteVector::Zero(), ByteVector::Zero(),
                                   ByteVector::Zero(), ByteVector::Zero(), ByteVector::Zero(),
                                   ByteVector::Zero(), ByteVector::Zero()};
  for (int i = 0; i < 8; ++i) pairs[i] = Min(difference[2 * i + 1], difference[(2 * i + 2) % kCircle]);
  ByteVector best = ByteVector::Zero();
  for (int i = 0; i < 8; ++i) {
    const ByteVector shared =
        Min(Min(pairs[i], pairs[(i + 1) % 8]), Min(pairs[(i + 2) % 8], pairs[(i + 3) % 8]));
    const ByteVector ends = Max(difference[2 * i], difference[(2 * i + 9) % kCircle]);
    best = Max(best, Min(shared, ends));
  }
  return best;
}

struct CircleReader {
  const uint8_t* centre;
  const std::array<ptrdiff_t, kCircle>& offsets;

  ByteVector At(int i) const { return ByteVector::Load(centre + offsets[i]); }
};

// An arc of nine holds two neighbouring ones of the four compass points, that is one of each opposite pair.
inline bool MayBeBright(const CircleReader& circle, ByteVector middle, ByteVector threshold) {
  const ByteVector brighter = Min(Max(circle.At(0), circle.At(8)), Max(circle.At(4), circle.At(12)));
  return Greater(Excess(brighter, middle), threshold) != 0;
}
inline bool MayBeDark(const CircleReader& circle, ByteVector middle, ByteVector threshold) {
  const ByteVector darker = Max(Min(circle.At(0), circle.At(8)), Min(circle.At(4), circle.At(12)));
  return Greater(Excess(middle, darker), threshold) != 0;
}

inline ByteVector BrightScore(const CircleReader& circle, ByteVector middle) {
  ByteVector difference[kCircle] = {
      Excess(circle.At(0), middle),  Excess(circle.At(1), middle),  Excess(circle.At(2), middle),
      Excess(circle.At(3), middle),  Excess(circle.At(4), middle),  Excess(circle.At(5), middle),
      Excess(circle.At(6), middle),  Excess(circle.At(7), middle),  Excess(circle.At(8), middle),
      Excess(circle.At(9), middle),  Excess(circle.At(10), middle), Excess(circle.At(11), middle),
      Excess(circle.At(12), middle), Excess(circle.At(13), middle), Excess(circle.At(14), middle),
      Excess(circle.At(15), middle)};
  return BestArc(difference);
}

inline ByteVector DarkScore(const CircleReader& circle, ByteVector middle) {
  ByteVector difference[kCircle] = {
      Excess(middle, circle.At(0)),  Excess(middle, circle.At(1)),  Excess(middle, circle.At(2)),
      Excess(middle, circle.At(3)),  Excess(middle, circle.At(4)),  Excess(middle, circle.At(5)),
      Excess(middle, circle.At(6)),  Excess(middle, circle.At(7)),  Excess(middle, circle.At(8)),
      Excess(middle, circle.At(9)),  Excess(middle, circle.At(10)), Excess(middle, circle.At(11)),
      Excess(middle, circle.At(12)), Excess(middle, circle.At(13)), Excess(middle, circle.At(14)),
      Excess(middle, circle.At(15))};
  return BestArc(difference);
}

// Appends the local maxima of a row of scores. Of equal neighbours the first counts.
void AppendMaxima(const uint8_t* above, const uint8_t* scores, const uint8_t* below, int count,
                  uint8_t threshold, int first_x, int y, std::vector<Corner>* corners) {
  const ByteVector floor = ByteVector::All(threshold);
  for (int i = 0; i < count; i += kLanes) {
    const ByteVector score = ByteVector::Load(scores + i);
    if (Greater(score, floor) == 0) continue;
    const ByteVector before = Max(Max(ByteVector::Load(above + i - 1), ByteVector::Load(above + i)),
                                  Max(ByteVector::Load(above + i + 1), ByteVector::Load(scores + i - 1)));
    const ByteVector after = Max(Max(ByteVector::Load(below + i - 1), ByteVector::Load(below + i)),
                                 Max(ByteVector::Load(below + i + 1), ByteVector::Load(scores + i + 1)));
    const ByteVector::Mask not_maximum = Greater(after, score);
    auto maxima = static_cast<ByteVector::Mask>(Greater(score, Max(before, floor)) & ~not_maximum);
    for (; maxima != 0; maxima &= static_cast<ByteVector::Mask>(maxima - 1)) {
      const int lane = i + std::countr_zero(maxima);
      corners->push_back({static_cast<uint16_t>(first_x + lane), static_cast<uint16_t>(y), scores[lane]});
    }
  }
}

}  // namespace

void FastDetector::ScoreRow(const uint8_t* row, ptrdiff_t step, int count, int threshold,
                            uint8_t* scores) const {
  const std::array<ptrdiff_t, kCircle> offsets = CircleOffsets(step);
  const ByteVector floor = ByteVector::All(static_cast<uint8_t>(threshold));
  for (int i = 0; i < count; i += kLanes) {
    const CircleReader circle{row + i, offsets};
    const ByteVector middle = ByteVector::Load(row + i);
    ByteVector score = ByteVector::Zero();
    if (MayBeBright(circle, middle, floor)) score = BrightScore(circle, middle);
    if (MayBeDark(circle, middle, floor)) score = Max(score, DarkScore(circle, middle));
    score.Store(scores + i);
  }
  // What the last vector saw beyond the region is no score.
  std::fill_n(scores + count, kLanes, uint8_t{0});
}

void FastDetector::Detect(const cv::Mat& image, const cv::Rect& region, int threshold,
                          std::vector<Corner>* corners) {
  corners->clear();
  if (region.empty()) return;
  const auto step = static_cast<ptrdiff_t>(image.step[0]);
  const int row_bytes = kLead + region.width + 2 * kLanes;
  scores_.assign(3 * static_cast<size_t>(row_bytes), 0);
  uint8_t* above = scores_.data() + kLead;
  uint8_t* current = above + row_bytes;
  uint8_t* below = current + row_bytes;
  const uint8_t floor = static_cast<uint8_t>(threshold);
  // `below` is scored one row ahead of the row whose maxima are taken.
  for (int y = region.y; y <= region.y + region.height; ++y) {
    if (y < region.y + region.height) {
      ScoreRow(image.ptr(y, region.x), step, region.width, threshold, below);
    } else {
      std::fill_n(below, region.width + kLanes, uint8_t{0});
    }
    AppendMaxima(above, current, below, region.width, floor, region.x, y - 1, corners);
    uint8_t* oldest = above;
    above = current;
    current = below;
    below = oldest;
  }
}

}  // namespace semmap
