#include "slam/features/fast_detector.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "slam/features/byte_vector.h"
#include "slam/features/padded_image.h"

namespace semmap {
namespace {

constexpr int kCircle = 16;
constexpr int kPixelsAtOnce = ByteVector::kLanes;
static_assert(kPixelsAtOnce <= kImagePadding);
// Bytes after each row of scores, which vectors and slots written ahead reach.
constexpr int kTail = 128;
// Corners that are written at once.
constexpr int kAhead = 4;

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

// Scores a row of `count` pixels: what each score exceeds `threshold` by.
void ScoreRow(const uint8_t* row, ptrdiff_t step, int count, uint8_t threshold, uint8_t* scores) {
  const std::array<ptrdiff_t, kCircle> offsets = CircleOffsets(step);
  const ByteVector floor = ByteVector::All(threshold);
  for (int i = 0; i < count; i += kPixelsAtOnce) {
    const CircleReader circle{row + i, offsets};
    const ByteVector middle = ByteVector::Load(row + i);
    ByteVector score = ByteVector::Zero();
    if (MayBeBright(circle, middle, floor)) score = BrightScore(circle, middle);
    if (MayBeDark(circle, middle, floor)) score = Max(score, DarkScore(circle, middle));
    Excess(score, floor).Store(scores + i);
  }
  // The frame; what the last vector saw beyond the region is no score.
  scores[-1] = 0;
  std::fill_n(scores + count, kPixelsAtOnce, uint8_t{0});
}

// Where a parabola through three neighbouring scores has its maximum, relative to the middle one, which is
// the greatest.
float ParabolaMaximum(int before, int middle, int after) {
  const int curvature = 2 * middle - before - after;
  return curvature > 0 ? 0.5F * static_cast<float>(after - before) / static_cast<float>(curvature) : 0.0F;
}

}  // namespace

// Makes room for the scores of a region, with a frame of zeros above and below.
void FastDetector::LayOut(const cv::Rect& region) {
  region_ = region;
  row_bytes_ = kLead + region.width + kTail;
  const size_t bytes = static_cast<size_t>(row_bytes_) * (region.height + 2);
  if (scores_.size() < bytes) scores_.resize(bytes);
  std::fill_n(ScoreRowOf(region.y - 1) - kLead, row_bytes_, uint8_t{0});
  std::fill_n(ScoreRowOf(region.y + region.height) - kLead, row_bytes_, uint8_t{0});
}

// Appends the local maxima of a row of scores. Of equal neighbours the first counts.
void FastDetector::AppendMaxima(int y, int threshold) {
  const uint8_t* scores = ScoreRowOf(y);
  const uint8_t* above = scores - row_bytes_;
  const uint8_t* below = scores + row_bytes_;
  // No two neighbours are maxima. Slots are written ahead of the count.
  const size_t most = corner_count_ + static_cast<size_t>(region_.width) / 2 + 1 + kAhead;
  if (corners_.size() < most) corners_.resize(2 * most);
  Corner* next = corners_.data() + corner_count_;
  for (int i = 0; i < region_.width; i += kPixelsAtOnce) {
    const ByteVector score = ByteVector::Load(scores + i);
    if (Greater(score, ByteVector::Zero()) == 0) continue;
    const ByteVector before = Max(Max(ByteVector::Load(above + i - 1), ByteVector::Load(above + i)),
                                  Max(ByteVector::Load(above + i + 1), ByteVector::Load(scores + i - 1)));
    const ByteVector after = Max(Max(ByteVector::Load(below + i - 1), ByteVector::Load(below + i)),
                                 Max(ByteVector::Load(below + i + 1), ByteVector::Load(scores + i + 1)));
    uint64_t maxima = Greater(score, before) & ~uint64_t{Greater(after, score)};
    Corner* end = next + std::popcount(maxima);
    // A few at a time whether or not there are as many: cheaper than a branch for each that is guessed
    // wrongly.
    for (; next < end; next += kAhead) {
      for (int k = 0; k < kAhead; ++k, maxima &= maxima - 1) {
        const int lane = i + std::countr_zero(maxima);
        next[k] = {static_cast<uint16_t>(region_.x + lane), static_cast<uint16_t>(y),
                   static_cast<uint8_t>(scores[lane] + threshold)};
      }
    }
    next = end;
  }
  corner_count_ = static_cast<size_t>(next - corners_.data());
}

std::span<const Corner> FastDetector::Detect(const cv::Mat& image, const cv::Rect& region, int threshold) {
  corner_count_ = 0;
  if (region.empty()) return {};
  LayOut(region);
  const auto step = static_cast<ptrdiff_t>(image.step[0]);
  // Maxima are taken one row behind the scores, while these are at hand.
  for (int y = region.y; y <= region.y + region.height; ++y) {
    if (y < region.y + region.height) {
      ScoreRow(image.ptr(y, region.x), step, region.width, static_cast<uint8_t>(threshold), ScoreRowOf(y));
    }
    if (y > region.y) AppendMaxima(y - 1, threshold);
  }
  return {corners_.data(), corner_count_};
}

cv::Point2f FastDetector::SubPixelOffset(const Corner& corner) const {
  const ptrdiff_t row = corner.y - region_.y + 1;
  const uint8_t* score = scores_.data() + row * row_bytes_ + kLead + corner.x - region_.x;
  return {ParabolaMaximum(score[-1], score[0], score[1]),
          ParabolaMaximum(score[-row_bytes_], score[0], score[row_bytes_])};
}

}  // namespace semmap
