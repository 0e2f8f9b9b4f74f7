#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "slam/common/ids.h"
#include "slam/common/mutex.h"
#include "slam/map/map_delta.h"
#include "storage/map_store.h"

namespace semmap::server {

// What a watcher has not been told yet: ids only, each at most once, however often a thing changes. What a
// thing is like is read from the store when it is told.
struct PendingChanges {
  std::set<KeyFrameId> keyframes;
  std::set<KeyFrameId> removed_keyframes;
  std::set<MapPointId> points;
  std::set<MapPointId> removed_points;
  bool reset = false;  // a part of the map was forgotten: tell everything anew
  // Of the map with all that was stored until now; 0: more of it is pending.
  uint64_t map_version = 0;

  bool empty() const {
    return !reset && keyframes.empty() && removed_keyframes.empty() && points.empty() &&
           removed_points.empty();
  }
  size_t size() const {
    return keyframes.size() + removed_keyframes.size() + points.size() + removed_points.size();
  }
  void Add(const MapDelta& delta);
};

// One viewer of a map. Thread-safe.
class MapWatcher {
 public:
  // `wake` is called, from any thread and without locks, when there is something to take.
  MapWatcher(size_t max_pending, std::function<void()> wake)
      : max_pending_(max_pending), wake_(std::move(wake)) {}

  // `map_version`: of the map with the delta.
  void Note(const MapDelta& delta, uint64_t map_version);
  // The map was changed otherwise, or is gone.
  void NoteReset();

  // At most `limit` of what is pending.
  PendingChanges Take(size_t limit);
  // More was pending than may be: the watcher has missed something.
  bool overrun() const;
  bool HasNews() const;

 private:
  const size_t max_pending_;
  const std::function<void()> wake_;
  mutable Mutex mutex_;  // guards all below
  PendingChanges pending_ ABSL_GUARDED_BY(mutex_);
  bool overrun_ ABSL_GUARDED_BY(mutex_) = false;
};

// Tells the watchers of a map what was stored. Thread-safe.
class MapWatchers {
 public:
  void Add(storage::MapId map, const std::shared_ptr<MapWatcher>& watcher);
  // A delta is in the store. To be called by who applies deltas, before the next.
  void OnStored(storage::MapStore& store, storage::MapId map, const MapDelta& delta);
  void OnReset(storage::MapId map);

 private:
  // Those that are still there.
  std::vector<std::shared_ptr<MapWatcher>> Of(storage::MapId map);

  Mutex mutex_;  // guards the list
  std::multimap<storage::MapId, std::weak_ptr<MapWatcher>> watchers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::server
