#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "semmap/v1/query.pb.h"
#include "storage/map_store.h"

namespace semmap::server {

v1::KeyFrame ToProto(const storage::KeyFrameEntry& entry, const std::string& session_name);

// Names of a map's sessions, asked of the store once each. Not thread-safe.
class SessionNames {
 public:
  SessionNames(storage::MapStore* store, storage::MapId map) : store_(store), map_(map) {}
  // "sessions/{session}" without the prefix. The store's errors.
  absl::StatusOr<std::string> NameOf(storage::SessionId session);

 private:
  storage::MapStore* store_;
  storage::MapId map_;
  std::map<storage::SessionId, std::string> names_;
};

}  // namespace semmap::server
