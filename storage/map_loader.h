#pragma once

#include <cstddef>

#include "absl/status/statusor.h"
#include "slam/map/map.h"
#include "storage/map_store.h"

namespace semmap::storage {

// A map in memory, as the store had it at one instant.
struct RestoredMap {
  MapInfo info;
  Map map;
  // Bytes that the map takes, give or take a tenth.
  size_t memory_bytes = 0;
};

// Reads a whole map from the store. `scale_info` is that of the extractor which made the features, `classes`
// says what becomes of points of classes that may move. RESOURCE_EXHAUSTED as soon as it takes more than
// `max_bytes`, DATA_LOSS when what is stored contradicts itself, and what MapStore::ReadWhole says. Takes a
// while. Thread-safe.
absl::StatusOr<RestoredMap> LoadMap(MapStore& store, MapId map, const ScalePyramidInfo& scale_info,
                                    size_t max_bytes, PointClassPolicy classes = {});

}  // namespace semmap::storage
