#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "server/server_config.h"
#include "server/vehicle_session.h"
#include "slam/semantics/segmentation_queue.h"
#include "storage/map_store.h"

namespace semmap::server {

// The whole service, listening. Made and drained by one thread.
class Server {
 public:
  // Listens on config.server.listen. UNAVAILABLE when that cannot be had, and what OpenMapStore says. Without
  // a vocabulary no place is found in stored maps; `segmentation` is for pictures that are looked for there.
  static absl::StatusOr<std::unique_ptr<Server>> Start(
      const Config& config, SlamSessionFactory factory,
      std::shared_ptr<const Vocabulary> vocabulary = nullptr,
      std::shared_ptr<SegmentationQueue> segmentation = nullptr);
  virtual ~Server() = default;

  virtual int port() const = 0;
  // HOST:PORT with the real port.
  virtual std::string address() const = 0;
  // Says NOT_SERVING, ends and stores all sessions, then stops listening; takes at most the configured drain
  // timeout and a moment. Idempotent.
  virtual void Drain() = 0;
};

}  // namespace semmap::server
