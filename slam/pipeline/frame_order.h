#pragma once

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "slam/pipeline/frame.h"

namespace semmap {

// Sequence numbers and times of a session's frames grow.
class FrameOrder {
 public:
  // INVALID_ARGUMENT when the frame may not follow those that were taken.
  absl::Status Check(const FrameInput& frame) const {
    if (!started_) return absl::OkStatus();
    if (frame.sequence <= last_sequence_) {
      return absl::InvalidArgumentError(
          absl::StrCat("sequence number ", frame.sequence, " follows ", last_sequence_));
    }
    if (frame.timestamp <= last_timestamp_) {
      return absl::InvalidArgumentError(
          absl::StrCat("timestamp ", frame.timestamp, " ns follows ", last_timestamp_, " ns"));
    }
    return absl::OkStatus();
  }

  void Take(const FrameInput& frame) {
    started_ = true;
    last_sequence_ = frame.sequence;
    last_timestamp_ = frame.timestamp;
  }

 private:
  bool started_ = false;
  uint64_t last_sequence_ = 0;
  TimestampNs last_timestamp_ = 0;
};

}  // namespace semmap
