#pragma once

#include <cstdint>

namespace semmap {

// A FAST corner in pixels of its pyramid level.
struct Corner {
  uint16_t x = 0;
  uint16_t y = 0;
  // The largest threshold, less one, that still calls this a corner.
  uint8_t score = 0;

  friend bool operator==(const Corner&, const Corner&) = default;
};

}  // namespace semmap
