#pragma once

#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "semmap/v1/map_service.pb.h"
#include "server/keyframe_conversion.h"
#include "server/map_watchers.h"
#include "server/service_context.h"

namespace semmap::server {

// What a watcher is told, message by message: first all that is there (unless it knows that), then what
// changes. One call at a time.
class WatchSource {
 public:
  // `wake` is called, from any thread, when there may be another message. Errors: NAME_INVALID,
  // MAP_NOT_FOUND.
  static absl::StatusOr<std::unique_ptr<WatchSource>> Make(const ServiceContext& context,
                                                           const v1::WatchMapRequest& request,
                                                           std::function<void()> wake);

  // False: nothing to tell now. WATCHER_TOO_SLOW, MAP_NOT_FOUND when the map was deleted.
  absl::StatusOr<bool> Next(v1::WatchMapResponse* response);
  // Next may have something to tell.
  bool HasNews() const { return phase_ != Phase::kLive || watcher_->HasNews(); }

 private:
  enum class Phase { kKeyFrames, kPoints, kLive };

  WatchSource(const ServiceContext& context, const v1::WatchMapRequest& request, storage::MapId map);
  void Begin();
  // The map as it is now. One that was made over has another id: then it is told anew.
  absl::StatusOr<storage::MapInfo> FindWatched();
  absl::Status TellKeyFrames(v1::WatchMapResponse* response);
  absl::Status TellPoints(v1::WatchMapResponse* response);
  absl::Status TellChanges(const PendingChanges& changes, v1::WatchMapResponse* response);
  absl::Status AddKeyFrame(const storage::KeyFrameEntry& entry, v1::WatchMapResponse* response);

  const ServiceContext& context_;
  const std::string name_;  // "maps/{map}"
  const bool keyframes_only_;
  storage::MapId map_;
  std::shared_ptr<MapWatcher> watcher_;
  Phase phase_ = Phase::kLive;
  bool tell_reset_ = false;
  uint64_t begun_at_version_ = 0;  // what is told in the first phases has at least this version
  KeyFrameId last_keyframe_;
  MapPointId last_point_;
  SessionNames names_;
};

}  // namespace semmap::server
