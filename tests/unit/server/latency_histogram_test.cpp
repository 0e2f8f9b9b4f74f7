#include "server/latency_histogram.h"

#include <gtest/gtest.h>

namespace semmap::server {
namespace {

TEST(LatencyHistogram, FindsQuantilesToFivePercent) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.Quantile(0.5), 0);
  for (int i = 1; i <= 1000; ++i) histogram.Add(i * 0.1);
  EXPECT_NEAR(histogram.Quantile(0.5), 50, 2.5);
  EXPECT_NEAR(histogram.Quantile(0.95), 95, 5);
  EXPECT_EQ(histogram.count(), 1000U);
}

TEST(LatencyHistogram, TakesAnyNumber) {
  LatencyHistogram histogram;
  histogram.Add(-1);
  histogram.Add(0);
  histogram.Add(1e12);
  EXPECT_GT(histogram.Quantile(1), 1000);
  EXPECT_LT(histogram.Quantile(0.1), 0.1);
}

}  // namespace
}  // namespace semmap::server
