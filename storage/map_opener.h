#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "slam/pipeline/map_part_cache.h"
#include "slam/pipeline/place_describer.h"
#include "slam/pipeline/stored_map.h"
#include "slam/place/place_config.h"
#include "storage/map_store.h"

namespace semmap::storage {

struct MapOpening {
  // Of the extractor that made the features, what becomes of points of classes that may move, and by which
  // vocabulary places are recognized.
  StoredMap::Reading reading;
  PlaceQueryLimits query;
  // For parts of the map that are read later.
  std::shared_ptr<MapPartCache> cache;
};

// Opens a map for looking for places in it: reads its outline and makes its place index, in a time that is
// that of some three kilobytes a keyframe. Of keyframes whose words are not stored (by this vocabulary)
// features are read, and the words kept for the next time. `store` outlives the map. RESOURCE_EXHAUSTED when
// outline and index take more than `max_bytes`; else what MapStore::ReadOutline and ReadParts say.
// Thread-safe.
absl::StatusOr<std::shared_ptr<const StoredMap>> OpenMap(MapStore& store, MapId map,
                                                         const MapOpening& opening, size_t max_bytes);

// What to tell a store that keeps words for OpenMap.
PlaceWording WordingOf(const PlaceDescriber& describer);

}  // namespace semmap::storage
