#include "client/frame_keeper.h"

#include <algorithm>
#include <utility>

namespace semmap::client {

void FrameKeeper::Add(v1::Frame frame) {
  last_added_ = frame.sequence();
  frames_.push_back(std::move(frame));
  Trim();
}

void FrameKeeper::OnAnswered(uint64_t sequence) {
  last_answered_ = std::max(last_answered_, sequence);
  Trim();
}

void FrameKeeper::OnAcknowledged(uint64_t sequence) {
  while (written_ > 0 && frames_.front().sequence() <= sequence) DropFront();
}

void FrameKeeper::Rewind(uint64_t last_received) {
  const auto behind = std::find_if(frames_.begin(), frames_.end(),
                                   [&](const v1::Frame& f) { return f.sequence() > last_received; });
  written_ = static_cast<size_t>(behind - frames_.begin());
}

void FrameKeeper::Trim() {
  while (frames_.size() > max_frames_ && written_ > 0 && frames_.front().sequence() <= last_answered_)
    DropFront();
}

void FrameKeeper::DropFront() {
  frames_.pop_front();
  --written_;
}

}  // namespace semmap::client
