#include "server/latency_histogram.h"

#include <algorithm>
#include <cmath>

namespace semmap::server {
namespace {

constexpr double kSmallest = 0.01;
constexpr double kGrowth = 1.05;

}  // namespace

void LatencyHistogram::Add(double milliseconds) {
  const double steps = std::log(std::max(milliseconds, kSmallest) / kSmallest) / std::log(kGrowth);
  const auto bucket = static_cast<size_t>(std::clamp(steps, 0.0, static_cast<double>(kBuckets - 1)));
  ++buckets_[bucket];
  ++count_;
}

double LatencyHistogram::Quantile(double fraction) const {
  if (count_ == 0) return 0;
  const auto rank = static_cast<uint64_t>(std::ceil(fraction * static_cast<double>(count_)));
  uint64_t seen = 0;
  for (size_t bucket = 0; bucket < kBuckets; ++bucket) {
    seen += buckets_[bucket];
    // The middle of the bucket, in the sense in which buckets grow.
    if (seen >= std::max<uint64_t>(rank, 1))
      return kSmallest * std::pow(kGrowth, static_cast<double>(bucket) + 0.5);
  }
  return kSmallest * std::pow(kGrowth, static_cast<double>(kBuckets));
}

}  // namespace semmap::server
