#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/map/map_outline.h"
#include "slam/map/map_parts.h"
#include "slam/pipeline/map_part_cache.h"
#include "slam/pipeline/map_snapshot.h"
#include "slam/pipeline/place_describer.h"
#include "slam/semantics/class_votes.h"

namespace semmap {

// A stored map of which only the outline and the place index are in memory. Features and points are read in
// the thread that needs them, and stay in a cache which many maps share. Answers what the whole map in memory
// would answer, bit for bit, as long as the store has the version of the outline. When it has a newer one,
// each view is of one version, all of it, but what belongs to it is still chosen by the old outline; what has
// gone since is left out.
class StoredMap : public MapSnapshot {
 public:
  // How what is read is understood.
  struct Reading {
    ScalePyramidInfo scale_info;
    PointClassPolicy classes;
    std::optional<PlaceDescriber> describer;
  };
  // What of a map is always in memory.
  struct Core {
    uint64_t version = 0;
    bool scale_known = true;
    MapOutline outline;
    std::optional<PlaceIndex> places;  // by the same vocabulary as the describer
  };

  // `number` tells the map from others in the cache.
  StoredMap(Reading reading, Core core, std::shared_ptr<MapPartSource> source,
            std::shared_ptr<MapPartCache> cache, uint64_t number);

  uint64_t version() const override { return core_.version; }
  bool scale_known() const override { return core_.scale_known; }
  const ScalePyramidInfo& scale_info() const override { return reading_.scale_info; }
  size_t keyframe_count() const override { return core_.outline.keyframe_count(); }
  size_t point_count() const override { return core_.outline.point_count(); }
  size_t memory_bytes() const override { return memory_bytes_; }
  const PlaceIndex* places() const override { return core_.places ? &*core_.places : nullptr; }
  PlaceDescription Describe(const FrameFeatures& features) const override {
    return reading_.describer->Describe(features);
  }
  std::optional<SE3> FindPose(KeyFrameId id) const override;
  void ForEachPose(absl::FunctionRef<void(const SE3& camera_from_map)> visit) const override;
  void ForEachObserver(MapPointId id, absl::FunctionRef<void(KeyFrameId)> visit) const override;
  absl::StatusOr<std::optional<PlaceCandidate>> Candidate(KeyFrameId id) const override;
  absl::StatusOr<std::shared_ptr<const LocalMapView>> ViewAround(
      KeyFrameId id, const LocalMapViewLimits& limits) const override;

 private:
  class Parts;
  class PartsAsSource;

  // Runs work(parts), first with what is in the cache and, where that is not enough, once more with the
  // store.
  template <typename Work>
  absl::Status WithParts(const Work& work) const;
  // nullptr when the keyframe is not there.
  absl::StatusOr<std::shared_ptr<const LocalMapView>> MakeView(KeyFrameId id,
                                                               const LocalMapViewLimits& limits,
                                                               Parts* parts) const;

  const Reading reading_;
  const Core core_;
  const std::shared_ptr<MapPartSource> source_;
  const std::shared_ptr<MapPartCache> cache_;
  const uint64_t number_;
  const size_t memory_bytes_;
  // That of the store when it was last read.
  mutable std::atomic<uint64_t> newest_version_;
};

}  // namespace semmap
