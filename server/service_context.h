#pragma once

#include <functional>
#include <memory>

#include "server/artifacts.h"
#include "server/map_cache.h"
#include "server/map_watchers.h"
#include "server/operations.h"
#include "server/request_log.h"
#include "server/server_config.h"
#include "server/session_registry.h"
#include "slam/common/time.h"
#include "slam/place/vocabulary.h"
#include "slam/semantics/segmentation_queue.h"
#include "storage/map_store.h"

namespace semmap::server {

// What the handlers of all calls work with. Pointers outlive every call.
struct ServiceContext {
  ServerConfig config;
  storage::MapStore* store = nullptr;
  SessionRegistry* sessions = nullptr;
  RequestLog* requests = nullptr;
  Timer* timer = nullptr;
  Operations* operations = nullptr;
  Artifacts* artifacts = nullptr;
  MapWatchers* watchers = nullptr;
  std::function<TimestampNs()> wall_clock;
  SlamConfig slam;
  MapCache* maps = nullptr;
  std::shared_ptr<const Vocabulary> vocabulary = nullptr;  // null: places are not recognized
  // Null: pictures have the classes that they bring.
  std::shared_ptr<SegmentationQueue> segmentation = nullptr;
};

}  // namespace semmap::server
