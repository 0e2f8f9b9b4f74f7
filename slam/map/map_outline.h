#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "slam/common/ids.h"
#include "slam/geometry/se3.h"

namespace semmap {

// What must be known of a map to find one's way in it before any keypoint or point is read: where the
// keyframes stand, and who sees which point. Keyframes go by their slots and points by their indices, both
// from 0 in order of ids, so that an observation takes four bytes in each direction. A value that nobody
// changes; thread-safe.
class MapOutline {
 public:
  struct Place {
    KeyFrameId id;
    SE3 camera_from_map;
  };

  size_t keyframe_count() const { return places_.size(); }
  // Points that a keyframe sees.
  size_t point_count() const { return point_ids_.size(); }

  // By slot.
  const std::vector<Place>& places() const { return places_; }
  std::optional<uint32_t> SlotOf(KeyFrameId id) const;
  std::optional<uint32_t> IndexOf(MapPointId id) const;
  MapPointId PointId(uint32_t index) const { return point_ids_[index]; }
  // Indices of the points that the keyframe sees, in the order of its keypoints.
  std::span<const uint32_t> PointsOf(uint32_t slot) const;
  // Slots of the keyframes that see the point, ascending.
  std::span<const uint32_t> ObserversOf(uint32_t index) const;

  size_t MemoryBytes() const;

 private:
  friend class MapOutlineBuilder;

  // Which of 64 ids in a row belong to points, and the index of the first that does.
  struct IdBlock {
    uint64_t used = 0;
    uint32_t first_index = 0;
  };

  std::vector<Place> places_;
  std::vector<uint32_t> points_begin_ = {0};  // by slot, and one behind the last
  std::vector<uint32_t> points_;
  std::vector<IdBlock> blocks_;
  std::vector<MapPointId> point_ids_;
  std::vector<uint32_t> observers_begin_;  // by index, and one behind the last
  std::vector<uint32_t> observers_;
};

// Puts an outline together from keyframes in order of their ids.
class MapOutlineBuilder {
 public:
  // No point has a greater id than `last_point`.
  MapOutlineBuilder(size_t keyframes, MapPointId last_point);

  // `points` in the order of the keypoints that see them. DATA_LOSS for ids out of order or range.
  absl::Status Add(KeyFrameId id, const SE3& map_from_camera, std::span<const MapPointId> points);
  // Of the outline as it will be.
  size_t MemoryBytes() const;
  MapOutline Finish() &&;

 private:
  void NumberPoints();
  void ListObservers();

  const MapPointId last_point_;
  MapOutline outline_;
  std::vector<MapPointId> seen_;  // behind each other, as outline_.points_ later
};

}  // namespace semmap
