#pragma once

#include <atomic>

#include "slam/common/ids.h"

namespace semmap {

// Hands out the ids of keyframes to all who make one map, each once and growing. Thread-safe.
class KeyFrameIdSource {
 public:
  // All ids are greater than `last`.
  explicit KeyFrameIdSource(KeyFrameId last = {}) : last_(last.value()) {}

  KeyFrameId Next() { return KeyFrameId(++last_); }

 private:
  std::atomic<uint64_t> last_;
};

}  // namespace semmap
