#pragma once

#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "aftermath.h"
#include "client/client.h"

namespace semmap::kill_test {

// Long work that a server does beside a drive, and what it may have left when it was killed in the middle.
class Work {
 public:
  virtual ~Work() = default;
  // Makes what it needs.
  virtual absl::Status Prepare(client::Client& /*client*/, const std::string& /*name*/) {
    return absl::OkStatus();
  }
  // Does it; `name` is new each time.
  virtual absl::Status Run(client::Client& client, const std::string& name) = 0;
  // Undoes what Prepare and Run did.
  virtual absl::Status Undo(client::Client& client, const std::string& name) = 0;
  // Kills what runs beside the server, if anything does.
  virtual void Kill() {}
  // After a kill and a restart; `done`: Run had returned OK.
  virtual void Inspect(Aftermath* aftermath, const std::string& name, bool done) = 0;
};

// All work on the map that `base` tells of, whose contents must not change by it.
std::unique_ptr<Work> CopyWork(const Testimony& base);
std::unique_ptr<Work> ImportWork(const Testimony& base, const std::string& file);
// Joins two copies of it.
std::unique_ptr<Work> MergeWork(const Testimony& base);
// `semmapd --backup` beside the server.
std::unique_ptr<Work> BackupWork(const Testimony& base, const std::string& config, const std::string& data);

}  // namespace semmap::kill_test
