#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "slam/map/local_map_view.h"
#include "slam/map/map.h"
#include "slam/pipeline/place_memory.h"
#include "slam/place/place_index.h"

namespace semmap {

// A keyframe that looks like an image, ready to be compared with it.
struct PlaceCandidate {
  // The keyframe and the points that it sees, in the order in which any view around it begins.
  std::shared_ptr<const LocalMapView> view;
  std::shared_ptr<const DirectIndex> nodes;
};

// What those see of a map who look for places in it: it was like this at one instant, or its parts were, see
// StoredMap. Thread-safe. A status says that the map could not be read.
class MapSnapshot {
 public:
  virtual ~MapSnapshot() = default;

  virtual uint64_t version() const = 0;
  // False while the unit of length is arbitrary (monocular).
  virtual bool scale_known() const = 0;
  virtual const ScalePyramidInfo& scale_info() const = 0;
  virtual size_t keyframe_count() const = 0;
  virtual size_t point_count() const = 0;
  // Bytes that it takes, give or take a tenth, parts that come and go left out.
  virtual size_t memory_bytes() const = 0;

  // nullptr without a vocabulary: then nothing is ever found, and Describe must not be called.
  virtual const PlaceIndex* places() const = 0;
  virtual PlaceDescription Describe(const FrameFeatures& features) const = 0;

  // camera_from_map of a keyframe; nullopt when there is none.
  virtual std::optional<SE3> FindPose(KeyFrameId id) const = 0;
  virtual void ForEachPose(absl::FunctionRef<void(const SE3& camera_from_map)> visit) const = 0;
  // The keyframes that see the point, in no particular order.
  virtual void ForEachObserver(MapPointId id, absl::FunctionRef<void(KeyFrameId)> visit) const = 0;

  // Needs a vocabulary. nullopt when the keyframe is not there (any more).
  virtual absl::StatusOr<std::optional<PlaceCandidate>> Candidate(KeyFrameId id) const = 0;
  // nullptr likewise.
  virtual absl::StatusOr<std::shared_ptr<const LocalMapView>> ViewAround(
      KeyFrameId id, const LocalMapViewLimits& limits) const = 0;
};

// A map in memory with its places, both of which outlive it and do not change meanwhile. Never fails to read.
class MapInMemory : public MapSnapshot {
 public:
  MapInMemory(const Map& map, const PlaceMemory& places, uint64_t version, bool scale_known = true)
      : map_(map), memory_(places), version_(version), scale_known_(scale_known) {}

  uint64_t version() const override { return version_; }
  bool scale_known() const override { return scale_known_; }
  const ScalePyramidInfo& scale_info() const override { return map_.scale_info(); }
  size_t keyframe_count() const override { return map_.keyframes().size(); }
  size_t point_count() const override { return map_.points().size(); }
  size_t memory_bytes() const override { return 0; }
  const PlaceIndex* places() const override { return memory_.enabled() ? &memory_.index() : nullptr; }
  PlaceDescription Describe(const FrameFeatures& features) const override {
    return memory_.Describe(features);
  }
  std::optional<SE3> FindPose(KeyFrameId id) const override;
  void ForEachPose(absl::FunctionRef<void(const SE3& camera_from_map)> visit) const override;
  void ForEachObserver(MapPointId id, absl::FunctionRef<void(KeyFrameId)> visit) const override;
  absl::StatusOr<std::optional<PlaceCandidate>> Candidate(KeyFrameId id) const override;
  absl::StatusOr<std::shared_ptr<const LocalMapView>> ViewAround(
      KeyFrameId id, const LocalMapViewLimits& limits) const override;

 private:
  const Map& map_;
  const PlaceMemory& memory_;
  const uint64_t version_;
  const bool scale_known_;
};

// A whole map that the snapshot owns; `map_bytes` is what it takes. Keypoints of the classes in `inactive`
// say nothing about a place.
std::shared_ptr<const MapSnapshot> MakeMapSnapshot(Map map, size_t map_bytes, uint64_t version,
                                                   bool scale_known,
                                                   std::shared_ptr<const Vocabulary> vocabulary,
                                                   const PlaceQueryLimits& limits,
                                                   const ClassSet& inactive = {});

}  // namespace semmap
