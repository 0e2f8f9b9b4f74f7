#include "server/frame_queue.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"

namespace semmap::server {
namespace {

absl::Status FrameError(v1::ErrorReason reason, uint64_t sequence, const char* what) {
  return Error(reason, absl::StrCat("frame ", sequence, what), {{"sequence", std::to_string(sequence)}});
}

}  // namespace

absl::Status FrameQueue::Push(v1::Frame frame, absl::Time now) {
  const uint64_t sequence = frame.sequence();
  if (credit_ <= 0) return FrameError(v1::ERROR_REASON_CREDIT_EXCEEDED, sequence, " was sent without credit");
  if (sequence > 0 && sequence <= resumed_at_) {
    --credit_;
    ++returned_;
    return absl::OkStatus();
  }
  if (sequence <= last_sequence_) {
    return FrameError(v1::ERROR_REASON_SEQUENCE_NOT_INCREASING, sequence,
                      " comes after one of a higher sequence");
  }
  if (received_ > 0 && frame.timestamp_ns() <= last_timestamp_) {
    return FrameError(v1::ERROR_REASON_TIME_NOT_INCREASING, sequence, " is not later than the one before");
  }
  --credit_;
  ++received_;
  last_sequence_ = sequence;
  last_timestamp_ = frame.timestamp_ns();
  QueuedFrame queued{std::move(frame), now, {}};
  if (policy_ == v1::OVERLOAD_POLICY_LATEST_WINS) {
    ++returned_;
    DropWaiting(&queued);
  }
  frames_.push_back(std::move(queued));
  return absl::OkStatus();
}

void FrameQueue::DropWaiting(QueuedFrame* newest) {
  for (QueuedFrame& waiting : frames_) {
    newest->dropped.insert(newest->dropped.end(), waiting.dropped.begin(), waiting.dropped.end());
    newest->dropped.push_back(waiting.frame.sequence());
    ++dropped_;
  }
  frames_.clear();
}

std::optional<QueuedFrame> FrameQueue::Pop() {
  if (frames_.empty()) return std::nullopt;
  QueuedFrame next = std::move(frames_.front());
  frames_.pop_front();
  ++in_process_;
  return next;
}

void FrameQueue::OnProcessed() {
  --in_process_;
  if (policy_ != v1::OVERLOAD_POLICY_LATEST_WINS) ++returned_;
}

void FrameQueue::Clear() { frames_.clear(); }

int FrameQueue::TakeReturnedCredit() {
  credit_ += returned_;
  return std::exchange(returned_, 0);
}

int FrameQueue::Restart() {
  // Under LATEST_WINS the frames under way have paid back already.
  const bool owed = policy_ != v1::OVERLOAD_POLICY_LATEST_WINS;
  const int under_way = owed ? static_cast<int>(frames_.size()) + in_process_ : 0;
  credit_ = window_ - under_way;
  returned_ = 0;
  resumed_at_ = last_sequence_;
  return credit_;
}

}  // namespace semmap::server
