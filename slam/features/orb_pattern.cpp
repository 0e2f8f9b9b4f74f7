#include "slam/features/orb_pattern.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace semmap {
namespace {

// Standard distributions differ between libraries; a sum of twelve uniform numbers is the same everywhere.
int GaussianOffset(std::mt19937& random, double sigma) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
  return static_cast<int>(std::lround(sum * sigma));
}

void GaussianPoint(std::mt19937& random, int8_t* x, int8_t* y) {
  constexpr double kSigma = (2 * kBriefRadius + 1) / 5.0;
  int dx = 0;
  int dy = 0;
  do {
    dx = GaussianOffset(random, kSigma);
    dy = GaussianOffset(random, kSigma);
  } while (dx * dx + dy * dy > kBriefRadius * kBriefRadius);
  *x = static_cast<int8_t>(dx);
  *y = static_cast<int8_t>(dy);
}

}  // namespace

BriefPattern GaussianPattern(uint32_t seed) {
  std::mt19937 random(seed);
  BriefPattern pattern;
  for (auto test = pattern.begin(); test != pattern.end(); ++test) {
    do {
      GaussianPoint(random, &test->x1, &test->y1);
      GaussianPoint(random, &test->x2, &test->y2);
    } while ((test->x1 == test->x2 && test->y1 == test->y2) ||
             std::find(pattern.begin(), test, *test) != test);
  }
  return pattern;
}

const BriefPattern& OrbPattern() {
  static constexpr BriefPattern kPattern = {{
#include "slam/features/orb_pattern.inc"
  }};
  return kPattern;
}

}  // namespace semmap
