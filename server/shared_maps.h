#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <set>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "slam/common/mutex.h"
#include "slam/pipeline/shared_map.h"
#include "storage/map_store.h"

namespace semmap::server {

// A map that sessions make or extend right now.
struct ExtendedMap {
  explicit ExtendedMap(std::shared_ptr<SharedMap> shared) : slam(std::move(shared)) {}

  const std::shared_ptr<SharedMap> slam;
  // A change did not reach the store: what follows it has nothing to stand on there, whoever made it.
  std::atomic<bool> store_failed = false;
};

// The maps that sessions make or extend right now, each in memory once for all of them. A session holds its
// map until the last of its changes is stored; when nobody holds it any more it is forgotten, and loaded anew
// for the next who comes. Thread-safe.
class SharedMaps {
 public:
  using Loader = std::function<absl::StatusOr<std::shared_ptr<ExtendedMap>>(const storage::MapInfo& map)>;

  explicit SharedMaps(Loader loader) : loader_(std::move(loader)) {}

  // A map that is new in the store.
  void Put(storage::MapId id, const std::shared_ptr<ExtendedMap>& map);
  // Waits while another caller loads the map. Errors of the loader; MAP_IN_USE when those who have it could
  // not store what they changed, until they are gone.
  absl::StatusOr<std::shared_ptr<ExtendedMap>> Get(const storage::MapInfo& map);

 private:
  const Loader loader_;
  Mutex mutex_;  // guards all below
  std::map<storage::MapId, std::weak_ptr<ExtendedMap>> maps_ ABSL_GUARDED_BY(mutex_);
  std::set<storage::MapId> loading_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::server
