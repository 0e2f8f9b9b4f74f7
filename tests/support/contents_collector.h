#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>

#include "slam/map/map_delta.h"

namespace semmap::testing {

// Keeps the points of a session as they are at the end, and all keyframes that there ever were.
class ContentsCollector : public MapDeltaSink {
 public:
  void OnDelta(MapDelta delta) override {
    for (const KeyFrameRecord& keyframe : delta.added_keyframes)
      keyframes[keyframe.sequence] = keyframe.features;
    for (const MapPointRecord& point : delta.upserted_points) points[point.id] = point;
    for (const MapPointId id : delta.removed_points) points.erase(id);
  }

  int Count(uint8_t semantic_class) const {
    return static_cast<int>(std::count_if(points.begin(), points.end(), [&](const auto& entry) {
      return entry.second.semantic_class == semantic_class;
    }));
  }

  std::map<uint64_t, std::shared_ptr<const FrameFeatures>> keyframes;  // by sequence
  std::map<MapPointId, MapPointRecord> points;
};

}  // namespace semmap::testing
