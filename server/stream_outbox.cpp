#include "server/stream_outbox.h"

#include <algorithm>
#include <utility>

namespace semmap::server {

void StreamOutbox::PutAnswer(v1::StreamFramesResponse answer, uint64_t sequence) {
  answers_.push_back({sequence, std::move(answer)});
}

void StreamOutbox::PutEstimate(v1::FrameEstimate estimate) {
  const uint64_t sequence = estimate.sequence();
  v1::StreamFramesResponse response;
  *response.mutable_estimate() = std::move(estimate);
  PutAnswer(std::move(response), sequence);
}

void StreamOutbox::PutDropped(const std::vector<uint64_t>& sequences, uint64_t total) {
  if (sequences.empty()) return;
  v1::StreamFramesResponse response;
  response.mutable_dropped()->mutable_sequences()->Assign(sequences.begin(), sequences.end());
  response.mutable_dropped()->set_total(total);
  PutAnswer(std::move(response), sequences.back());
}

void StreamOutbox::PutAcknowledgement(uint64_t sequence) {
  acknowledged_ = std::max(acknowledged_, sequence);
}

void StreamOutbox::PutCorrections(std::vector<v1::MapCorrection> corrections) {
  corrections_ = std::move(corrections);
  corrections_taken_ = 0;
}

bool StreamOutbox::Take(v1::StreamFramesResponse* response) {
  if (taken_ < answers_.size()) {
    *response = answers_[taken_++].response;
    if (taken_ > kept_answers_) {
      answers_.pop_front();
      --taken_;
    }
    return true;
  }
  if (corrections_taken_ < corrections_.size()) {
    *response->mutable_correction() = corrections_[corrections_taken_++];
    return true;
  }
  if (acknowledged_ > acknowledged_taken_) {
    acknowledged_taken_ = acknowledged_;
    response->mutable_acknowledgement()->set_sequence(acknowledged_);
    return true;
  }
  return false;
}

void StreamOutbox::Rewind(uint64_t last_answered) {
  while (!answers_.empty() && answers_.front().sequence <= last_answered) answers_.pop_front();
  taken_ = 0;
  corrections_taken_ = 0;
}

}  // namespace semmap::server
