#include "slam/semantics/class_votes.h"

#include <algorithm>

namespace semmap {

ClassVotes::ClassVotes(const std::vector<ClassVote>& votes) {
  for (const ClassVote& vote : votes) {
    if (vote.count > 0) Add(vote.semantic_class, vote.count);
  }
}

void ClassVotes::Add(uint8_t semantic_class, uint32_t count) {
  if (semantic_class == kUnknownClass) return;
  for (ClassVote& vote : votes_) {
    if (vote.semantic_class != semantic_class) continue;
    vote.count += count;
    return;
  }
  votes_.push_back({semantic_class, count});
}

void ClassVotes::Add(const ClassVotes& others) {
  for (const ClassVote& vote : others.votes_) Add(vote.semantic_class, vote.count);
}

void ClassVotes::Remove(uint8_t semantic_class) {
  const auto vote = std::find_if(votes_.begin(), votes_.end(),
                                 [&](const ClassVote& v) { return v.semantic_class == semantic_class; });
  if (vote != votes_.end() && --vote->count == 0) votes_.erase(vote);
}

uint32_t ClassVotes::total() const {
  uint32_t sum = 0;
  for (const ClassVote& vote : votes_) sum += vote.count;
  return sum;
}

uint8_t ClassVotes::MostFrequent() const {
  const auto most = std::max_element(
      votes_.begin(), votes_.end(), [](const ClassVote& a, const ClassVote& b) { return a.count < b.count; });
  return most == votes_.end() ? kUnknownClass : most->semantic_class;
}

float ClassVotes::ShareOf(uint8_t semantic_class) const {
  for (const ClassVote& vote : votes_) {
    if (vote.semantic_class == semantic_class)
      return static_cast<float>(vote.count) / static_cast<float>(total());
  }
  return 0;
}

}  // namespace semmap
