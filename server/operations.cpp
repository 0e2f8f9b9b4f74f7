#include "server/operations.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"
#include "server/names.h"
#include "server/session_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr int kMaxRunning = 16;
constexpr size_t kMaxRemembered = 1000;

absl::Status NotThere(const std::string& id) {
  return Error(v1::ERROR_REASON_OPERATION_NOT_FOUND, absl::StrCat("there is no operation ", id));
}

// What the caller of CancelOperation wanted has no reason in the table; every other failure has.
google::rpc::Status ToError(const absl::Status& status, bool closing) {
  if (!absl::IsCancelled(status)) return ToRpcStatus(status);
  if (closing) return ToRpcStatus(Error(v1::ERROR_REASON_OPERATION_INTERRUPTED, "the server was stopped"));
  google::rpc::Status error;
  error.set_code(static_cast<int>(status.code()));
  error.set_message(std::string(status.message()));
  return error;
}

}  // namespace

void OperationProgress::Tell(const v1::OptimizeReport& report) {
  MutexLock lock(&mutex_);
  *report_.mutable_optimize() = report;
}

void OperationProgress::Tell(const v1::PruneReport& report) {
  MutexLock lock(&mutex_);
  *report_.mutable_prune() = report;
}

Operations::Operations(Executor* threads, std::function<TimestampNs()> wall_clock)
    : threads_(threads), wall_clock_(std::move(wall_clock)) {}

Operations::~Operations() {
  Stop();
  MutexLock lock(&mutex_);
  mutex_.Await(&Operations::NothingRuns, this);
}

void Operations::Stop() {
  std::vector<std::pair<Done, v1::Operation>> answers;
  {
    MutexLock lock(&mutex_);
    closing_ = true;
    for (const auto& [number, entry] : entries_) {
      if (!entry->operation.done()) entry->progress.cancel_requested_ = true;
      for (Done& done : entry->waiting) answers.emplace_back(std::move(done), Describe(*entry));
      entry->waiting.clear();
    }
  }
  for (const auto& [done, operation] : answers) done(operation);
}

absl::StatusOr<v1::Operation> Operations::Start(v1::OperationKind kind,
                                                const std::vector<std::string>& map_ids, Work work) {
  const auto entry = std::make_shared<Entry>();
  MutexLock lock(&mutex_);
  if (closing_) return Error(v1::ERROR_REASON_SHUTTING_DOWN, "the server is stopping");
  if (running_ >= kMaxRunning) {
    return Error(v1::ERROR_REASON_TOO_MANY_REQUESTS, "too many operations are under way");
  }
  ++running_;
  const uint64_t number = ++last_number_;
  entry->operation.set_name(OperationName(absl::StrCat(number)));
  v1::OperationMetadata* metadata = entry->operation.mutable_metadata();
  metadata->set_kind(kind);
  for (const std::string& id : map_ids) metadata->add_maps(MapName(id));
  *metadata->mutable_create_time() = ToTimestamp(wall_clock_());
  entries_.emplace(number, entry);
  ForgetOldest();
  threads_->Schedule(
      [this, entry, work = std::move(work)]() mutable { Run(entry, std::exchange(work, nullptr)); });
  return Describe(*entry);
}

void Operations::Run(const std::shared_ptr<Entry>& entry, Work work) {
  Result result = absl::CancelledError("the operation was cancelled before it began");
  if (!entry->progress.CancelRequested()) result = work(entry->progress);
  // What the work holds on to (maps that nobody else may use meanwhile) is free when the first one hears that
  // it is done, and is not touched after the destructor.
  work = nullptr;
  Finish(entry, result);
}

void Operations::Finish(const std::shared_ptr<Entry>& entry, const Result& result) {
  std::vector<Done> waiting;
  v1::Operation last;
  {
    MutexLock lock(&mutex_);
    v1::Operation& operation = entry->operation;
    operation.set_done(true);
    *operation.mutable_metadata()->mutable_end_time() = ToTimestamp(wall_clock_());
    if (result.ok()) {
      entry->progress.Report(1);
      operation.mutable_response()->PackFrom(**result);
    } else {
      *operation.mutable_error() = ToError(result.status(), closing_);
    }
    std::swap(waiting, entry->waiting);
    last = Describe(*entry);
  }
  spdlog::info("operation done name={} kind={} status={}", last.name(),
               v1::OperationKind_Name(last.metadata().kind()),
               result.ok() ? "OK" : result.status().ToString());
  for (const Done& done : waiting) done(last);
  // Only now: the destructor waits for this, and nothing of ours is touched afterwards.
  MutexLock lock(&mutex_);
  --running_;
}

void Operations::ForgetOldest() {
  for (auto oldest = entries_.begin(); entries_.size() > kMaxRemembered && oldest != entries_.end();) {
    oldest = oldest->second->operation.done() ? entries_.erase(oldest) : std::next(oldest);
  }
}

v1::Operation Operations::Describe(const Entry& entry) {
  v1::Operation operation = entry.operation;
  {
    MutexLock lock(&entry.progress.mutex_);
    operation.mutable_metadata()->MergeFrom(entry.progress.report_);
  }
  operation.mutable_metadata()->set_stage(entry.progress.stage_);
  operation.mutable_metadata()->set_progress(std::clamp(entry.progress.share_.load(), 0.0, 1.0));
  operation.mutable_metadata()->set_cancel_requested(entry.progress.CancelRequested());
  return operation;
}

absl::StatusOr<std::shared_ptr<Operations::Entry>> Operations::Find(const std::string& id) const {
  uint64_t number = 0;
  if (!absl::SimpleAtoi(id, &number)) return NotThere(id);
  const auto found = entries_.find(number);
  if (found == entries_.end()) return NotThere(id);
  return found->second;
}

absl::StatusOr<v1::Operation> Operations::Get(const std::string& id) const {
  MutexLock lock(&mutex_);
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Entry> entry, Find(id));
  return Describe(*entry);
}

std::vector<v1::Operation> Operations::List(const std::string& map_id) const {
  MutexLock lock(&mutex_);
  std::vector<v1::Operation> operations;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    const auto& maps = entry->second->operation.metadata().maps();
    const bool wanted = map_id.empty() || std::find(maps.begin(), maps.end(), MapName(map_id)) != maps.end();
    if (wanted) operations.push_back(Describe(*entry->second));
  }
  return operations;
}

absl::Status Operations::WhenDone(const std::string& id, Done done) {
  v1::Operation now;
  {
    MutexLock lock(&mutex_);
    SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Entry> entry, Find(id));
    if (!entry->operation.done() && !closing_) {
      entry->waiting.push_back(std::move(done));
      return absl::OkStatus();
    }
    now = Describe(*entry);
  }
  done(now);
  return absl::OkStatus();
}

absl::Status Operations::Cancel(const std::string& id) {
  MutexLock lock(&mutex_);
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Entry> entry, Find(id));
  if (!entry->operation.done()) entry->progress.cancel_requested_ = true;
  return absl::OkStatus();
}

absl::Status Operations::Forget(const std::string& id) {
  MutexLock lock(&mutex_);
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Entry> entry, Find(id));
  if (!entry->operation.done()) {
    return Error(v1::ERROR_REASON_FIELD_INVALID, "the operation is not done", {{"field", "name"}});
  }
  std::erase_if(entries_, [&](const auto& other) { return other.second == entry; });
  return absl::OkStatus();
}

}  // namespace semmap::server
