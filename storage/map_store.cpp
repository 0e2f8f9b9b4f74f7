#include "storage/map_store.h"

#include <map>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "slam/common/mutex.h"
#include "storage/sqlite/sqlite_map_store.h"

namespace semmap::storage {
namespace {

// Backends by the scheme of their URIs.
class BackendRegistry {
 public:
  static BackendRegistry& Instance() {
    static BackendRegistry registry;
    return registry;
  }

  absl::Status Add(std::string_view scheme, MapStoreFactory factory) {
    MutexLock lock(&mutex_);
    if (factories_.try_emplace(std::string(scheme), std::move(factory)).second) return absl::OkStatus();
    return absl::AlreadyExistsError(absl::StrCat("a storage backend for ", std::string(scheme), " exists"));
  }

  absl::StatusOr<MapStoreFactory> Find(std::string_view uri) {
    const std::string scheme(uri.substr(0, uri.find(':')));
    MutexLock lock(&mutex_);
    const auto found = factories_.find(scheme);
    if (uri.find(':') != std::string_view::npos && found != factories_.end()) return found->second;
    return absl::InvalidArgumentError(absl::StrCat("no storage backend opens \"", std::string(uri), "\""));
  }

 private:
  Mutex mutex_;
  std::map<std::string, MapStoreFactory> factories_ ABSL_GUARDED_BY(mutex_){
      {"sqlite", &sqlite::OpenSqliteMapStore}};
};

}  // namespace

absl::Status MapStore::SetAnchor(MapId map, const std::optional<GeoAnchor>& anchor) {
  return UpdateMap(map, {.anchor = anchor}).status();
}

absl::StatusOr<std::unique_ptr<MapStore>> OpenMapStore(const StorageConfig& config) {
  absl::StatusOr<MapStoreFactory> factory = BackendRegistry::Instance().Find(config.uri);
  if (!factory.ok()) return factory.status();
  return (*factory)(config);
}

absl::Status RegisterMapStoreBackend(std::string_view scheme, MapStoreFactory factory) {
  if (scheme.empty() || factory == nullptr)
    return absl::InvalidArgumentError("a backend needs scheme and factory");
  return BackendRegistry::Instance().Add(scheme, std::move(factory));
}

}  // namespace semmap::storage
