#pragma once

#include "absl/status/statusor.h"

namespace semmap::server {

// A streamed answer, made piece by piece as the client takes it. One call at a time.
template <typename Response>
class ChunkSource {
 public:
  virtual ~ChunkSource() = default;
  // Fills the next message; false: there is none.
  virtual absl::StatusOr<bool> Next(Response* response) = 0;
};

}  // namespace semmap::server
