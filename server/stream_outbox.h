#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "semmap/v1/session.pb.h"

namespace semmap::server {

// What a session has to say to its vehicle and has not said yet. Acknowledgements are merged while they wait;
// answers to frames are not, but there are never more than the vehicle has credit for. Answers are kept for
// a while after they were taken, because a stream that breaks loses what was under way; Rewind brings them
// back. Of corrections only the newest set counts, since each covers the whole session. Not thread-safe.
class StreamOutbox {
 public:
  // `kept_answers`: how many answers that were taken are kept.
  explicit StreamOutbox(size_t kept_answers) : kept_answers_(kept_answers) {}

  void PutEstimate(v1::FrameEstimate estimate);
  void PutDropped(const std::vector<uint64_t>& sequences, uint64_t total);
  void PutAcknowledgement(uint64_t sequence);
  void PutCorrections(std::vector<v1::MapCorrection> corrections);

  // The next message to write; false when there is none. Answers first.
  bool Take(v1::StreamFramesResponse* response);

  // A new stream takes over: all answers after `last_answered` are waiting again, and the corrections.
  void Rewind(uint64_t last_answered);

 private:
  void PutAnswer(v1::StreamFramesResponse answer, uint64_t sequence);

  struct Answer {
    uint64_t sequence = 0;  // the highest that it answers
    v1::StreamFramesResponse response;
  };
  const size_t kept_answers_;
  std::deque<Answer> answers_;
  size_t taken_ = 0;  // of answers_, from the front
  std::vector<v1::MapCorrection> corrections_;
  size_t corrections_taken_ = 0;
  uint64_t acknowledged_ = 0;
  uint64_t acknowledged_taken_ = 0;
};

}  // namespace semmap::server
