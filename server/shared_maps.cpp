#include "server/shared_maps.h"

#include "server/error_reasons.h"

namespace semmap::server {

void SharedMaps::Put(storage::MapId id, const std::shared_ptr<ExtendedMap>& map) {
  MutexLock lock(&mutex_);
  maps_[id] = map;
}

absl::StatusOr<std::shared_ptr<ExtendedMap>> SharedMaps::Get(const storage::MapInfo& map) {
  {
    MutexLock lock(&mutex_);
    const auto nobody_loads = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return !loading_.contains(map.id);
    };
    mutex_.Await(nobody_loads);
    if (auto held = maps_[map.id].lock()) {
      if (!held->store_failed) return held;
      return Error(v1::ERROR_REASON_MAP_IN_USE, "sessions end whose changes of the map could not be stored");
    }
    loading_.insert(map.id);
  }
  auto loaded = loader_(map);
  MutexLock lock(&mutex_);
  loading_.erase(map.id);
  std::erase_if(maps_, [](const auto& entry) { return entry.second.expired(); });
  if (loaded.ok()) maps_[map.id] = *loaded;
  return loaded;
}

}  // namespace semmap::server
