#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "semmap/v1/frame.pb.h"
#include "semmap/v1/session.pb.h"

namespace semmap::server {

// A frame that waits for its turn.
struct QueuedFrame {
  v1::Frame frame;
  absl::Time arrival;
  // Frames that gave way to this one.
  std::vector<uint64_t> dropped;
};

// The frames of one session between arrival and tracker: order, credit and the overload policy. A frame costs
// one credit; it comes back when the frame was processed (BLOCK) or at once (LATEST_WINS). Not thread-safe.
class FrameQueue {
 public:
  FrameQueue(int window, v1::OverloadPolicy policy) : window_(window), policy_(policy), credit_(window) {}

  // Takes a frame that arrived. Errors: SEQUENCE_NOT_INCREASING, TIME_NOT_INCREASING, CREDIT_EXCEEDED; the
  // queue is then as before. A frame that an earlier stream brought already is passed over.
  absl::Status Push(v1::Frame frame, absl::Time now);
  // The next one for the tracker.
  std::optional<QueuedFrame> Pop();
  // After the tracker is through with a frame that Pop gave.
  void OnProcessed();
  void Clear();

  // Credit to hand back, and from then on the vehicle's.
  int TakeReturnedCredit();
  // A new stream begins: returns the credit that it starts with.
  int Restart();

  bool empty() const { return frames_.empty(); }
  uint64_t last_sequence() const { return last_sequence_; }
  uint64_t received() const { return received_; }
  uint64_t dropped() const { return dropped_; }

 private:
  void DropWaiting(QueuedFrame* newest);

  const int window_;
  const v1::OverloadPolicy policy_;
  std::deque<QueuedFrame> frames_;
  int in_process_ = 0;
  int credit_;        // that the vehicle has
  int returned_ = 0;  // to be handed back
  uint64_t last_sequence_ = 0;
  int64_t last_timestamp_ = 0;
  uint64_t resumed_at_ = 0;  // sequences up to here came by an earlier stream
  uint64_t received_ = 0;
  uint64_t dropped_ = 0;
};

}  // namespace semmap::server
