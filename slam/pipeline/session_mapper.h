#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "slam/pipeline/full_bundle.h"
#include "slam/pipeline/local_mapper.h"
#include "slam/pipeline/loop_closer.h"
#include "slam/pipeline/map_localizer.h"
#include "slam/pipeline/piece_join.h"
#include "slam/pipeline/place_memory.h"
#include "slam/pipeline/recovery.h"
#include "slam/pipeline/relocalizer.h"

namespace semmap {

// What the mapper remembers of one of the vehicles that make a map.
struct VehicleMapping {
  // Joined a map that others made: a wrong place would spoil what is theirs, so it is looked for harder.
  bool is_stranger = false;
  YoungPoints young_points;
  LoopCloser loop_closer;
  // Views are made around it: the vehicle's newest keyframe, or where it was found. None before either.
  KeyFrameId center;
};

// What happens to a map behind its trackers' backs, as single steps: local mapping, loop closing, finding a
// lost tracker, adjusting the whole map. Several vehicles may make one map; a step is one vehicle's. Not
// thread-safe: its queue calls it from one thread at a time.
class SessionMapper {
 public:
  // Without a vocabulary there are no loops and no recoveries.
  SessionMapper(const SlamConfig& config, const MappingCamera& camera, const ScalePyramidInfo& scale_info,
                std::shared_ptr<const Vocabulary> vocabulary, LocalMapper::Publish publish);

  // Before anything else: goes on in a map that was stored.
  void Adopt(Map map);
  // Of a vehicle that begins to take part.
  VehicleMapping StartVehicle(bool is_stranger) const;

  // `stop` becomes true when the next keyframe waits: what can be left out then is.
  void AddKeyFrame(const KeyFrameCandidate& candidate, const std::atomic<bool>* stop,
                   VehicleMapping* vehicle);
  void AddInitialPair(const InitialPair& pair, VehicleMapping* vehicle);
  // Forgets the map, which the vehicle made alone.
  void Reset(VehicleMapping* vehicle);

  // Closes a loop that ends at the vehicle's keyframe added last. Every vehicle should then see the map anew.
  std::optional<LoopCloser::Result> CloseLoop(VehicleMapping* vehicle);

  struct RecoveryReport {
    std::shared_ptr<const Recovery> recovery;  // null: see failure
    LocalizationFailure failure = LocalizationFailure::kNone;
  };
  // Looks for the frame anywhere in the map; if it is found the vehicle's view moves there.
  RecoveryReport Recover(const LostFrame& lost, VehicleMapping* vehicle);

  // Of a piece that the vehicle mapped before it found itself here. Every vehicle should then see the map
  // anew.
  PieceJoinReport Join(const PieceJoin& join);
  // Nothing is done with the mapper afterwards.
  Map TakeMap() { return std::move(local_.mutable_map()); }

  // A copy of the whole map to be adjusted elsewhere, and its way back, after which every vehicle should see
  // the map anew.
  std::shared_ptr<FullBundle> PrepareFullBundle() const;
  void Apply(const FullBundle& bundle) { bundle.Apply(&local_.mutable_map()); }

  // Publishes the map as it is around the vehicle, which has a center.
  void PublishView(const VehicleMapping& vehicle) { local_.PublishView(vehicle.center); }

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
  Found Find(const TrackedFrame& frame, const VehicleMapping& vehicle) const;

  SlamConfig config_;
  MappingCamera camera_;
  LocalMapper local_;
  PlaceMemory places_;
  Relocalizer relocalizer_;
  MapLocalizer localizer_;
};

}  // namespace semmap
