#pragma once

#include <cstdint>

namespace semmap {

// Nanoseconds; what zero means is the source's choice (Unix epoch or start of recording).
using TimestampNs = int64_t;

constexpr double kSecondsPerNanosecond = 1e-9;

inline double ToSeconds(TimestampNs nanoseconds) {
  return static_cast<double>(nanoseconds) * kSecondsPerNanosecond;
}

inline TimestampNs FromSeconds(double seconds) {
  return static_cast<TimestampNs>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5));
}

}  // namespace semmap
