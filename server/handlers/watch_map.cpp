#include "server/handlers/watch_map.h"

#include <utility>
#include <vector>

#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/point_columns.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

absl::StatusOr<std::unique_ptr<WatchSource>> WatchSource::Make(const ServiceContext& context,
                                                               const v1::WatchMapRequest& request,
                                                               std::function<void()> wake) {
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo found, FindMap(context, "map", request.map()));
  std::unique_ptr<WatchSource> source(new WatchSource(context, request, found.id));
  source->watcher_ =
      std::make_shared<MapWatcher>(static_cast<size_t>(context.config.watcher_backlog), std::move(wake));
  // First to listen, then to look: nothing is missed in between.
  context.watchers->Add(found.id, source->watcher_);
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "map", request.map()));
  source->begun_at_version_ = map.version;
  if (request.after_version() != map.version || map.version == 0) source->Begin();
  return source;
}

WatchSource::WatchSource(const ServiceContext& context, const v1::WatchMapRequest& request,
                         storage::MapId map)
    : context_(context),
      name_(request.map()),
      keyframes_only_(request.keyframes_only()),
      map_(map),
      names_(context.store, map) {}

void WatchSource::Begin() {
  phase_ = Phase::kKeyFrames;
  tell_reset_ = true;
  last_keyframe_ = {};
  last_point_ = {};
}

absl::StatusOr<storage::MapInfo> WatchSource::FindWatched() {
  auto known = context_.store->GetMap(map_);
  if (known.ok()) return known;
  if (!absl::IsNotFound(known.status())) return FromStore(known.status());
  SEMMAP_ASSIGN_OR_RETURN(storage::MapInfo map, FindMap(context_, "map", name_));
  map_ = map.id;
  names_ = SessionNames(context_.store, map_);
  context_.watchers->Add(map_, watcher_);
  // That it was made over is known now.
  watcher_->Take(0);
  begun_at_version_ = map.version;
  Begin();
  return map;
}

absl::StatusOr<bool> WatchSource::Next(v1::WatchMapResponse* response) {
  if (watcher_->overrun()) {
    return Error(v1::ERROR_REASON_WATCHER_TOO_SLOW, "the map changes faster than the watcher reads");
  }
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindWatched());
  if (phase_ == Phase::kLive) {
    const PendingChanges changes = watcher_->Take(static_cast<size_t>(context_.config.query_chunk));
    if (changes.empty()) return false;
    if (!changes.reset) {
      response->set_map_version(changes.map_version);
      SEMMAP_RETURN_IF_ERROR(TellChanges(changes, response));
      return true;
    }
    begun_at_version_ = map.version;
    Begin();
  }
  response->set_reset(std::exchange(tell_reset_, false));
  SEMMAP_RETURN_IF_ERROR(phase_ == Phase::kKeyFrames ? TellKeyFrames(response) : TellPoints(response));
  if (phase_ == Phase::kLive) response->set_map_version(begun_at_version_);
  return true;
}

absl::Status WatchSource::AddKeyFrame(const storage::KeyFrameEntry& entry, v1::WatchMapResponse* response) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string name, names_.NameOf(entry.session));
  *response->add_keyframes() = ToProto(entry, name);
  return absl::OkStatus();
}

absl::Status WatchSource::TellKeyFrames(v1::WatchMapResponse* response) {
  storage::KeyFrameQuery query;
  query.after = last_keyframe_;
  query.limit = static_cast<size_t>(context_.config.query_chunk);
  // Names are asked for afterwards: a visitor must not call the store.
  std::vector<storage::KeyFrameEntry> entries;
  SEMMAP_RETURN_IF_ERROR(FromStore(context_.store->ForEachKeyFrame(map_, query, [&](const auto& entry) {
    entries.push_back(entry);
    return true;
  })));
  for (const storage::KeyFrameEntry& entry : entries) SEMMAP_RETURN_IF_ERROR(AddKeyFrame(entry, response));
  if (entries.size() == query.limit) {
    last_keyframe_ = entries.back().record.id;
  } else {
    phase_ = keyframes_only_ ? Phase::kLive : Phase::kPoints;
  }
  return absl::OkStatus();
}

absl::Status WatchSource::TellPoints(v1::WatchMapResponse* response) {
  storage::MapPointQuery query;
  query.after = last_point_;
  query.limit = static_cast<size_t>(context_.config.query_chunk);
  size_t told = 0;
  SEMMAP_RETURN_IF_ERROR(
      FromStore(context_.store->ForEachMapPoint(map_, query, [&](const MapPointRecord& point) {
        AppendPoint(point, point.position_in_map, PointColumns(), response->mutable_points());
        last_point_ = point.id;
        ++told;
        return true;
      })));
  if (told < query.limit) phase_ = Phase::kLive;
  return absl::OkStatus();
}

// What went meanwhile will be told as removed.
absl::Status WatchSource::TellChanges(const PendingChanges& changes, v1::WatchMapResponse* response) {
  for (const KeyFrameId id : changes.removed_keyframes) response->add_removed_keyframe_ids(id.value());
  for (const KeyFrameId id : changes.keyframes) {
    const auto entry = context_.store->GetKeyFrame(map_, id);
    if (absl::IsNotFound(entry.status())) continue;
    if (!entry.ok()) return FromStore(entry.status());
    SEMMAP_RETURN_IF_ERROR(AddKeyFrame(*entry, response));
  }
  if (keyframes_only_) return absl::OkStatus();
  for (const MapPointId id : changes.removed_points) response->add_removed_point_ids(id.value());
  const std::vector<MapPointId> ids(changes.points.begin(), changes.points.end());
  const auto points = context_.store->GetMapPoints(map_, ids);
  if (!points.ok()) return FromStore(points.status());
  for (const MapPointRecord& point : *points) {
    AppendPoint(point, point.position_in_map, PointColumns(), response->mutable_points());
  }
  return absl::OkStatus();
}

}  // namespace semmap::server
