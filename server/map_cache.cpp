#include "server/map_cache.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/error_reasons.h"
#include "slam/common/notification.h"
#include "storage/map_opener.h"

namespace semmap::server {
namespace {

// A map that changes all the time is loaded for at most this share of the time.
constexpr double kLoadShare = 0.1;

absl::Status TooLarge(const char* what) {
  return Error(v1::ERROR_REASON_MAP_TOO_LARGE,
               absl::StrCat(what, " than the server is configured to hold in memory"));
}

}  // namespace

MapCache::MapCache(const Limits& limits, Loader loader, Executor* threads,
                   std::shared_ptr<MapPartCache> parts)
    : limits_(limits), loader_(std::move(loader)), threads_(threads), parts_(std::move(parts)) {}

MapCache::~MapCache() {
  MutexLock lock(&mutex_);
  closing_ = true;
  mutex_.Await([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return loads_ == 0; });
}

bool MapCache::IsFreshEnough(const Entry& entry, uint64_t version) const {
  if (entry.snapshot == nullptr) return false;
  if (entry.snapshot->version() == version) return true;
  const absl::Duration pause = std::max(limits_.min_reload_interval, entry.load_time / kLoadShare);
  return absl::Now() - entry.loaded_at < pause;
}

void MapCache::Get(const storage::MapInfo& map, Ready ready) {
  Snapshot snapshot;
  {
    MutexLock lock(&mutex_);
    Entry& entry = entries_[map.id];
    entry.last_use = ++uses_;
    if (IsFreshEnough(entry, map.version)) {
      snapshot = entry.snapshot;
    } else {
      entry.waiting.push_back(std::move(ready));
      if (std::exchange(entry.loading, true)) return;
      ++loads_;
    }
  }
  if (snapshot != nullptr) {
    ready(std::move(snapshot));
  } else {
    threads_->Schedule([this, id = map.id] { Load(id); });
  }
}

absl::StatusOr<MapCache::Snapshot> MapCache::GetAndWait(const storage::MapInfo& map) {
  Notification done;
  absl::StatusOr<Snapshot> result;
  Get(map, [&](absl::StatusOr<Snapshot> loaded) {
    result = std::move(loaded);
    done.Notify();
  });
  done.WaitForNotification();
  return result;
}

void MapCache::Load(storage::MapId map) {
  size_t room = 0;
  bool cancelled = false;
  {
    MutexLock lock(&mutex_);
    const size_t held = HeldBytes();
    room = held < MaxBytes() ? MaxBytes() - held : 0;
    cancelled = closing_;
  }
  const absl::Time start = absl::Now();
  absl::StatusOr<Snapshot> loaded =
      cancelled ? absl::CancelledError("the server is stopping") : loader_(map, room);
  const absl::Duration load_time = absl::Now() - start;
  if (loaded.ok()) {
    spdlog::info("map loaded id={} version={} keyframes={} points={} bytes={} ms={:.0f}", map.value(),
                 (*loaded)->version(), (*loaded)->keyframe_count(), (*loaded)->point_count(),
                 (*loaded)->memory_bytes(), absl::ToDoubleMilliseconds(load_time));
  }
  Finish(map, std::move(loaded), load_time);
}

void MapCache::Finish(storage::MapId map, absl::StatusOr<Snapshot> loaded, absl::Duration load_time) {
  std::vector<Ready> waiting;
  // What goes must not die under the lock: that may take a while.
  std::vector<Snapshot> gone;
  {
    MutexLock lock(&mutex_);
    Entry& entry = entries_[map];
    if (loaded.ok() && !MakeRoom(map, (*loaded)->memory_bytes(), &gone)) {
      loaded = absl::ResourceExhaustedError("no room beside the maps that are in use");
    }
    entry.loading = false;
    entry.loaded_at = absl::Now();
    entry.load_time = load_time;
    waiting = std::exchange(entry.waiting, {});
    if (loaded.ok()) {
      if (entry.snapshot != nullptr) {
        replaced_.push_back(entry.snapshot);
        gone.push_back(std::move(entry.snapshot));
      }
      entry.snapshot = *loaded;
    } else if (absl::IsResourceExhausted(loaded.status()) && entry.snapshot != nullptr) {
      // Two versions at once do not fit as long as somebody uses the old one.
      loaded = entry.snapshot;
    } else {
      if (entry.snapshot != nullptr) gone.push_back(std::move(entry.snapshot));
      entries_.erase(map);
    }
  }
  if (parts_ != nullptr) {
    MutexLock lock(&mutex_);
    const size_t taken = AllBytes();
    parts_->SetMaxBytes(limits_.max_bytes - std::min(taken, limits_.max_bytes));
  }
  if (absl::IsResourceExhausted(loaded.status())) loaded = TooLarge("the map takes more");
  for (const Ready& ready : waiting) ready(loaded);
  gone.clear();
  // Last: after it the cache may go.
  MutexLock lock(&mutex_);
  --loads_;
}

size_t MapCache::HeldBytes() const {
  size_t bytes = 0;
  for (const auto& [id, entry] : entries_) {
    if (entry.snapshot != nullptr && entry.snapshot.use_count() > 1) bytes += entry.snapshot->memory_bytes();
  }
  for (const auto& weak : replaced_) {
    if (const auto snapshot = weak.lock()) bytes += snapshot->memory_bytes();
  }
  return bytes;
}

bool MapCache::MakeRoom(storage::MapId kept, size_t bytes, std::vector<Snapshot>* gone) {
  std::erase_if(replaced_, [](const auto& weak) { return weak.expired(); });
  const auto free_at_will = [kept](const auto& entry) {
    return entry.first != kept && entry.second.snapshot != nullptr && entry.second.snapshot.use_count() == 1;
  };
  size_t unused = 0;
  for (const auto& entry : entries_) {
    if (free_at_will(entry)) unused += entry.second.snapshot->memory_bytes();
  }
  const size_t held = HeldBytes() + bytes;
  if (held > MaxBytes()) return false;
  while (held + unused > MaxBytes()) {
    auto oldest = entries_.end();
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      if (!free_at_will(*entry)) continue;
      if (oldest == entries_.end() || entry->second.last_use < oldest->second.last_use) oldest = entry;
    }
    if (oldest == entries_.end()) return true;
    unused -= oldest->second.snapshot->memory_bytes();
    gone->push_back(std::move(oldest->second.snapshot));
    if (!oldest->second.loading) entries_.erase(oldest);
  }
  return true;
}

size_t MapCache::AllBytes() const {
  size_t bytes = HeldBytes();
  for (const auto& [id, entry] : entries_) {
    if (entry.snapshot != nullptr && entry.snapshot.use_count() == 1) bytes += entry.snapshot->memory_bytes();
  }
  return bytes;
}

size_t MapCache::memory_bytes() const {
  const size_t part_bytes = parts_ == nullptr ? 0 : parts_->memory_bytes();
  MutexLock lock(&mutex_);
  return AllBytes() + part_bytes;
}

MapCache::Loader MakeMapLoader(storage::MapStore* store, const SlamConfig& slam,
                               std::shared_ptr<const Vocabulary> vocabulary,
                               std::shared_ptr<MapPartCache> parts) {
  if (parts == nullptr) parts = std::make_shared<MapPartCache>(0);
  storage::MapOpening opening{
      {ScalePyramidInfo(slam.orb.levels, slam.orb.scale_factor), slam.semantics.PointPolicy(), std::nullopt},
      slam.place.query,
      std::move(parts)};
  if (vocabulary != nullptr) {
    opening.reading.describer.emplace(std::move(vocabulary), slam.semantics.InactiveClasses());
    store->StoreWordsBy(storage::WordingOf(*opening.reading.describer));
  }
  return [store, opening](storage::MapId map, size_t max_bytes) -> absl::StatusOr<MapCache::Snapshot> {
    auto opened = storage::OpenMap(*store, map, opening, max_bytes);
    if (absl::IsResourceExhausted(opened.status())) return opened.status();
    if (!opened.ok()) return FromStore(opened.status());
    return *std::move(opened);
  };
}

}  // namespace semmap::server
