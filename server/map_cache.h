#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "slam/common/mutex.h"
#include "slam/pipeline/executor.h"
#include "slam/pipeline/map_part_cache.h"
#include "slam/pipeline/map_snapshot.h"
#include "slam/pipeline/slam_config.h"
#include "storage/map_store.h"

namespace semmap::server {

// Stored maps that are looked for places in, each open once for all. A map is opened when it is first asked
// for, and anew when it has changed; what others hold of it stays as it was. What is always in memory of a
// map is counted here, and the maps that were not asked for longest go when there is no room for it; parts of
// maps share what is left (MapPartCache). Thread-safe; holds no thread while it loads but its own.
class MapCache {
 public:
  using Snapshot = std::shared_ptr<const MapSnapshot>;
  // Opens a map of the store; RESOURCE_EXHAUSTED when it takes more bytes than it is given.
  using Loader = std::function<absl::StatusOr<Snapshot>(storage::MapId map, size_t max_bytes)>;
  using Ready = std::function<void(absl::StatusOr<Snapshot>)>;

  struct Limits {
    // For all maps together, those that left but are still in use included, and their parts.
    size_t max_bytes = size_t{512} << 20;
    // Of that, what parts have in any case.
    size_t min_part_bytes = 0;
    // A map that changes all the time is not loaded more often than this, nor for more than a tenth of the
    // time: meanwhile the last snapshot is given.
    absl::Duration min_reload_interval = absl::Seconds(1);
  };

  // `threads` outlives the cache. `parts` are those of the maps that the loader opens; null: they have none.
  MapCache(const Limits& limits, Loader loader, Executor* threads,
           std::shared_ptr<MapPartCache> parts = nullptr);
  // Waits for the loads under way; who waits for them is answered CANCELLED.
  ~MapCache();
  MapCache(const MapCache&) = delete;
  MapCache& operator=(const MapCache&) = delete;

  // Calls `ready` once: in the caller's thread if the map is there, else on the cache's when it is loaded.
  // `map` as the store has it now. Errors, besides those of the store: MAP_TOO_LARGE when there is no room
  // for it beside the maps that are in use.
  void Get(const storage::MapInfo& map, Ready ready);
  // The same for who may wait.
  absl::StatusOr<Snapshot> GetAndWait(const storage::MapInfo& map);

  // Bytes of the maps that are held, or were and are in use, and of the parts that are there of them.
  size_t memory_bytes() const;

 private:
  struct Entry {
    Snapshot snapshot;  // null before the first load, and when it had to make room
    absl::Time loaded_at = absl::InfinitePast();
    absl::Duration load_time = absl::ZeroDuration();
    uint64_t last_use = 0;
    bool loading = false;
    std::vector<Ready> waiting;
  };

  bool IsFreshEnough(const Entry& entry, uint64_t version) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Load(storage::MapId map);
  void Finish(storage::MapId map, absl::StatusOr<Snapshot> loaded, absl::Duration load_time);
  // What maps may take without their parts.
  size_t MaxBytes() const { return limits_.max_bytes - std::min(limits_.min_part_bytes, limits_.max_bytes); }
  // Of all snapshots, and of those that somebody uses.
  size_t AllBytes() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  size_t HeldBytes() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Moves unused maps other than `kept` into `gone` until `bytes` more fit; false if they cannot.
  bool MakeRoom(storage::MapId kept, size_t bytes, std::vector<Snapshot>* gone)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Limits limits_;
  const Loader loader_;
  Executor* const threads_;
  const std::shared_ptr<MapPartCache> parts_;
  mutable Mutex mutex_;  // guards all below
  std::map<storage::MapId, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  // Older versions, as long as anybody uses them.
  std::vector<std::weak_ptr<const MapSnapshot>> replaced_ ABSL_GUARDED_BY(mutex_);
  uint64_t uses_ ABSL_GUARDED_BY(mutex_) = 0;
  int loads_ ABSL_GUARDED_BY(mutex_) = 0;
  bool closing_ ABSL_GUARDED_BY(mutex_) = false;
};

// Opens maps of `store`, whose places it finds by `vocabulary` and the limits of `slam`; without a vocabulary
// nothing is ever found. With one, the store keeps the words of keyframes from now on. Without `parts`
// nothing that was read stays in memory.
MapCache::Loader MakeMapLoader(storage::MapStore* store, const SlamConfig& slam,
                               std::shared_ptr<const Vocabulary> vocabulary,
                               std::shared_ptr<MapPartCache> parts = nullptr);

}  // namespace semmap::server
