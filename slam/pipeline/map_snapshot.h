#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "slam/map/map.h"
#include "slam/pipeline/place_memory.h"

namespace semmap {

// A whole map as it was at one instant, ready to be searched. Nobody changes it any more, so that any number
// of threads may read it.
struct MapSnapshot {
  Map map;
  PlaceMemory places;
  uint64_t version = 0;
  // False while the unit of length is arbitrary (monocular).
  bool scale_known = true;
  // Bytes that all of it takes, give or take a tenth.
  size_t memory_bytes = 0;
};

// Indexes the places of `map`, which took `map_bytes` so far. Keypoints of the classes in `inactive` say
// nothing about a place.
std::shared_ptr<const MapSnapshot> MakeMapSnapshot(Map map, size_t map_bytes, uint64_t version,
                                                   bool scale_known,
                                                   std::shared_ptr<const Vocabulary> vocabulary,
                                                   const PlaceQueryLimits& limits,
                                                   const ClassSet& inactive = {});

}  // namespace semmap
