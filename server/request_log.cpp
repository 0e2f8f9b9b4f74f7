#include "server/request_log.h"

#include <utility>

namespace semmap::server {
namespace {

constexpr size_t kMaxAnswers = 1000;

}  // namespace

std::optional<std::string> RequestLog::Find(const std::string& method, const std::string& request_id) const {
  if (request_id.empty()) return std::nullopt;
  MutexLock lock(&mutex_);
  const auto found = answers_.find(method + "/" + request_id);
  if (found == answers_.end()) return std::nullopt;
  return found->second;
}

void RequestLog::Remember(const std::string& method, const std::string& request_id, std::string answer) {
  if (request_id.empty()) return;
  MutexLock lock(&mutex_);
  const auto [entry, added] = answers_.emplace(method + "/" + request_id, std::move(answer));
  if (!added) return;
  order_.push_back(entry->first);
  if (order_.size() <= kMaxAnswers) return;
  answers_.erase(order_.front());
  order_.pop_front();
}

}  // namespace semmap::server
