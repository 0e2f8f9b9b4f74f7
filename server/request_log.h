#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"

namespace semmap::server {

// Remembers the answers to the last thousand requests that carried a request id, so that one which is sent
// again because its answer got lost is not done twice. Thread-safe.
class RequestLog {
 public:
  // Serialized answer to the request `request_id` of `method`; nothing for new and for empty ids.
  std::optional<std::string> Find(const std::string& method, const std::string& request_id) const;
  void Remember(const std::string& method, const std::string& request_id, std::string answer);

 private:
  mutable Mutex mutex_;  // guards the answers
  std::map<std::string, std::string> answers_ ABSL_GUARDED_BY(mutex_);
  std::deque<std::string> order_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::server
