#include "slam/pipeline/loop_closer.h"

namespace semmap {

std::optional<LoopCloser::Result> LoopCloser::Close(KeyFrameId keyframe, const PlaceMemory& places,
                                                    Map* map) {
  if (!config_.enabled || !places.enabled()) return std::nullopt;
  ++keyframes_;
  if (last_loop_at_ && keyframes_ < *last_loop_at_ + static_cast<uint64_t>(config_.min_interval))
    return std::nullopt;
  for (const KeyFrameId candidate : detector_.Detect(*map, places, keyframe)) {
    const auto loop = VerifyLoop(config_, seed_, camera_, places, *map, candidate, keyframe);
    if (!loop) continue;
    const LoopCorrection correction = CloseLoop(config_, camera_, *loop, map);
    detector_.Reset();
    last_loop_at_ = keyframes_;
    return Result{*loop, correction};
  }
  return std::nullopt;
}

void LoopCloser::Reset() {
  detector_.Reset();
  last_loop_at_.reset();
}

}  // namespace semmap
