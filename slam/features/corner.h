#pragma once

#include <cstdint>

namespace semmap {

// A FAST corner in pixels of its pyramid level.
struct Corner {
  uint16_t x = 0;
  uint16_t y = 0;
  // Least difference to the centre on the best arc: a corner at every threshold below.
  uint8_t score = 0;

  friend bool operator==(const Corner&, const Corner&) = default;
};

}  // namespace semmap
