#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "slam/pipeline/full_bundle.h"
#include "slam/pipeline/local_mapper.h"
#include "slam/pipeline/loop_closer.h"
#include "slam/pipeline/map_localizer.h"
#include "slam/pipeline/place_memory.h"
#include "slam/pipeline/recovery.h"
#include "slam/pipeline/relocalizer.h"

namespace semmap {

// What a session does with its map behind the tracker's back, as single steps: local mapping, loop closing,
// finding a lost tracker, adjusting the whole map. Not thread-safe: its queue calls it from one thread at a
// time.
class SessionMapper {
 public:
  // Without a vocabulary there are no loops and no recoveries.
  SessionMapper(const SlamConfig& config, const MappingCamera& camera, const ScalePyramidInfo& scale_info,
                std::shared_ptr<const Vocabulary> vocabulary, LocalMapper::Publish publish);

  // Before anything else: goes on in a map that was stored. Nothing is published before the first recovery.
  void Adopt(Map map);

  // `stop` becomes true when the next keyframe waits: what can be left out then is.
  void AddKeyFrame(const KeyFrameCandidate& candidate, const std::atomic<bool>* stop);
  void AddInitialPair(const InitialPair& pair);
  // Forgets the map.
  void Reset();

  // Closes a loop that ends at the keyframe added last.
  std::optional<LoopCloser::Result> CloseLoop();

  struct RecoveryReport {
    std::shared_ptr<const Recovery> recovery;  // null: see failure
    LocalizationFailure failure = LocalizationFailure::kNone;
  };
  // Looks for the frame anywhere in the map; if it is found the published view moves there.
  RecoveryReport Recover(const LostFrame& lost);

  // A copy of the whole map to be adjusted elsewhere, and its way back.
  std::shared_ptr<FullBundle> PrepareFullBundle() const;
  void Apply(const FullBundle& bundle);

  const Map& map() const { return local_.map(); }
  // Of the view published last.
  uint64_t view_version() const { return local_.view_version(); }
  // Changes since the last call.
  MapDelta TakeDelta() { return local_.TakeDelta(); }

 private:
  // Where a frame was found.
  struct Found {
    std::shared_ptr<const LocalMapView> view;
    std::optional<ViewFix> fix;
    LocalizationFailure failure = LocalizationFailure::kNone;
  };
  Found Find(const TrackedFrame& frame) const;

  SlamConfig config_;
  MappingCamera camera_;
  LocalMapper local_;
  PlaceMemory places_;
  LoopCloser loop_closer_;
  Relocalizer relocalizer_;
  // In a stored map a wrong place would spoil what others made: looks harder before it believes.
  MapLocalizer localizer_;
  bool map_is_stored_ = false;
};

}  // namespace semmap
