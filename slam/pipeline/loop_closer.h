#pragma once

#include <optional>

#include "slam/pipeline/loop_corrector.h"
#include "slam/pipeline/loop_detector.h"

namespace semmap {

// Finds and closes loops as the keyframes of one vehicle come: detection, verification, correction. Not
// thread-safe; belongs to the map's owner.
class LoopCloser {
 public:
  LoopCloser(const LoopConfig& config, uint32_t seed, const MappingCamera& camera)
      : config_(config), seed_(seed), camera_(camera), detector_(config) {}

  struct Result {
    Loop loop;
    LoopCorrection correction;
  };
  // Looks for a loop that ends at `keyframe`, which must be in `places`, and closes it in the map. Called for
  // each keyframe.
  std::optional<Result> Close(KeyFrameId keyframe, const PlaceMemory& places, Map* map);
  void Reset();

 private:
  LoopConfig config_;
  uint32_t seed_;
  MappingCamera camera_;
  LoopDetector detector_;
  uint64_t keyframes_ = 0;
  // How many keyframes there had been when the last loop was closed.
  std::optional<uint64_t> last_loop_at_;
};

}  // namespace semmap
