#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace semmap::server {

// Quantiles of durations in constant memory: buckets grow by 5 %, from 10 microseconds to a minute. Not
// thread-safe.
class LatencyHistogram {
 public:
  void Add(double milliseconds);
  // The duration that a share `fraction` of all stays at or below, to 5 %; 0 when there are none.
  double Quantile(double fraction) const;
  uint64_t count() const { return count_; }

 private:
  static constexpr size_t kBuckets = 320;
  std::array<uint64_t, kBuckets> buckets_{};
  uint64_t count_ = 0;
};

}  // namespace semmap::server
