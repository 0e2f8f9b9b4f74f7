#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "semmap/v1/frame.pb.h"

namespace semmap::client {

// The frames of a drive that may have to be sent again: those that are not durable yet, bounded. Frames that
// the server has answered are given up first when there are too many; the server still has those, unless it
// crashes. Not thread-safe.
class FrameKeeper {
 public:
  explicit FrameKeeper(size_t max_frames) : max_frames_(max_frames) {}

  void Add(v1::Frame frame);
  // Whether a frame waits to be written.
  bool HasUnwritten() const { return written_ < frames_.size(); }
  // The first of them, which counts as written from now on.
  const v1::Frame& TakeUnwritten() { return frames_[written_++]; }

  void OnAnswered(uint64_t sequence);
  void OnAcknowledged(uint64_t sequence);
  // A new stream: the server has received the frames up to `last_received`, all others are to be written
  // again.
  void Rewind(uint64_t last_received);

  uint64_t last_answered() const { return last_answered_; }
  uint64_t last_added() const { return last_added_; }
  size_t size() const { return frames_.size(); }

 private:
  void DropFront();
  void Trim();

  const size_t max_frames_;
  std::deque<v1::Frame> frames_;
  size_t written_ = 0;  // of frames_, from the front
  uint64_t last_answered_ = 0;
  uint64_t last_added_ = 0;
};

}  // namespace semmap::client
