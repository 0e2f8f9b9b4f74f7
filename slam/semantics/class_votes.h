#pragma once

#include <cstdint>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "slam/semantics/taxonomy.h"

namespace semmap {

struct ClassVote {
  uint8_t semantic_class = kUnknownClass;
  uint32_t count = 0;

  friend bool operator==(const ClassVote&, const ClassVote&) = default;
};

// As what classes a thing was seen, and how often as each, in the order in which they were seen first. A
// value that needs no memory of its own for up to two classes, which is what nearly all points have.
class ClassVotes {
 public:
  ClassVotes() = default;
  // From records; members without a count or class are left out.
  explicit ClassVotes(const std::vector<ClassVote>& votes);

  // kUnknownClass is no vote.
  void Add(uint8_t semantic_class, uint32_t count = 1);
  void Add(const ClassVotes& others);
  // Takes one vote back; nothing where there is none.
  void Remove(uint8_t semantic_class);

  bool empty() const { return votes_.empty(); }
  uint32_t total() const;
  // The class with most votes; among equals the one that was seen first, so that a class changes only when
  // another one has more votes. kUnknownClass without votes.
  uint8_t MostFrequent() const;
  // What was seen first (of what was not taken back).
  uint8_t First() const { return empty() ? kUnknownClass : votes_.front().semantic_class; }
  // Share of the votes, [0, 1]; 0 without votes.
  float ShareOf(uint8_t semantic_class) const;

  std::vector<ClassVote> ToVector() const { return {votes_.begin(), votes_.end()}; }

 private:
  absl::InlinedVector<ClassVote, 2> votes_;
};

// How a point's class follows from its votes, and what classes put it aside.
struct PointClassPolicy {
  // The most frequent class; false: the first.
  bool majority = true;
  // Points of these classes are inactive.
  ClassSet inactive;

  uint8_t ClassOf(const ClassVotes& votes) const { return majority ? votes.MostFrequent() : votes.First(); }
  bool IsActive(uint8_t semantic_class) const { return !inactive.Contains(semantic_class); }
};

}  // namespace semmap
