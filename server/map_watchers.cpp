#include "server/map_watchers.h"

#include <utility>

namespace semmap::server {
namespace {

// Moves up to `limit` ids over; what is left of the limit.
template <typename Id>
size_t MoveSome(size_t limit, std::set<Id>* from, std::set<Id>* to) {
  while (limit > 0 && !from->empty()) {
    to->insert(from->extract(from->begin()));
    --limit;
  }
  return limit;
}

}  // namespace

void PendingChanges::Add(const MapDelta& delta) {
  reset = reset || delta.reset;
  for (const KeyFrameRecord& added : delta.added_keyframes) keyframes.insert(added.id);
  for (const KeyFramePose& moved : delta.moved_keyframes) keyframes.insert(moved.id);
  for (const KeyFrameObservations& seen : delta.observations) keyframes.insert(seen.id);
  for (const MapPointRecord& point : delta.upserted_points) {
    points.insert(point.id);
    removed_points.erase(point.id);
  }
  for (const RemovedKeyFrame& removal : delta.removed_keyframes) {
    keyframes.erase(removal.removed);
    removed_keyframes.insert(removal.removed);
  }
  for (const MapPointId id : delta.removed_points) {
    points.erase(id);
    removed_points.insert(id);
  }
}

void MapWatcher::Note(const MapDelta& delta, uint64_t map_version) {
  {
    MutexLock lock(&mutex_);
    if (overrun_) return;
    pending_.Add(delta);
    pending_.map_version = map_version;
    if (pending_.size() > max_pending_) {
      overrun_ = true;
      pending_ = PendingChanges();
    }
  }
  wake_();
}

void MapWatcher::NoteReset() {
  {
    MutexLock lock(&mutex_);
    pending_.reset = true;
  }
  wake_();
}

PendingChanges MapWatcher::Take(size_t limit) {
  MutexLock lock(&mutex_);
  PendingChanges taken;
  if (std::exchange(pending_.reset, false)) {
    // Everything is told anew: nothing else matters.
    pending_ = PendingChanges();
    taken.reset = true;
    return taken;
  }
  // What is gone first: a viewer should not show for long what is not there.
  limit = MoveSome(limit, &pending_.removed_keyframes, &taken.removed_keyframes);
  limit = MoveSome(limit, &pending_.removed_points, &taken.removed_points);
  limit = MoveSome(limit, &pending_.keyframes, &taken.keyframes);
  MoveSome(limit, &pending_.points, &taken.points);
  if (pending_.empty()) taken.map_version = pending_.map_version;
  return taken;
}

bool MapWatcher::overrun() const {
  MutexLock lock(&mutex_);
  return overrun_;
}

bool MapWatcher::HasNews() const {
  MutexLock lock(&mutex_);
  return overrun_ || !pending_.empty();
}

void MapWatchers::Add(storage::MapId map, const std::shared_ptr<MapWatcher>& watcher) {
  MutexLock lock(&mutex_);
  watchers_.emplace(map, watcher);
}

std::vector<std::shared_ptr<MapWatcher>> MapWatchers::Of(storage::MapId map) {
  std::vector<std::shared_ptr<MapWatcher>> result;
  MutexLock lock(&mutex_);
  auto [next, end] = watchers_.equal_range(map);
  while (next != end) {
    if (auto watcher = next->second.lock()) {
      result.push_back(std::move(watcher));
      ++next;
    } else {
      next = watchers_.erase(next);
    }
  }
  return result;
}

void MapWatchers::OnStored(storage::MapStore& store, storage::MapId map, const MapDelta& delta) {
  const auto watchers = Of(map);
  if (watchers.empty()) return;
  const auto info = store.GetMap(map);
  // A map that is gone is found out by who reads it next.
  for (const auto& watcher : watchers) watcher->Note(delta, info.ok() ? info->version : 0);
}

void MapWatchers::OnReset(storage::MapId map) {
  for (const auto& watcher : Of(map)) watcher->NoteReset();
}

}  // namespace semmap::server
