#pragma once

#include <cstdint>
#include <vector>

#include "semmap/v1/frame.pb.h"

namespace semmap::server {

// Where a satellite receiver said that the vehicle was.
struct GnssSample {
  uint64_t sequence = 0;  // of the frame
  double latitude_deg = 0;
  double longitude_deg = 0;
  double altitude_m = 0;
  double horizontal_accuracy_m = 0;
};

// The fixes of one drive, a bounded number: when there are more, every second one goes. Not thread-safe.
class GnssTrack {
 public:
  // Passes over what is no fix (a place that is not on Earth, no accuracy).
  void Add(uint64_t sequence, const v1::GnssFix& fix);
  const std::vector<GnssSample>& samples() const { return samples_; }

 private:
  std::vector<GnssSample> samples_;
  uint64_t stride_ = 1;  // one of so many is kept
  uint64_t seen_ = 0;
};

}  // namespace semmap::server
