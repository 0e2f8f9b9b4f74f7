#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "slam/common/ids.h"
#include "slam/place/place_config.h"
#include "slam/place/place_description.h"
#include "slam/place/posting.h"
#include "slam/place/vocabulary.h"

namespace semmap {

struct PlaceMatch {
  KeyFrameId keyframe;
  double score = 0;      // Similarity of the two bags
  int shared_words = 0;  // words that both have

  friend bool operator==(const PlaceMatch&, const PlaceMatch&) = default;
};

// Which keyframes look like an image: an inverted index from words to the keyframes that have them (Sivic and
// Zisserman, Video Google, ICCV 2003). One owner writes; queries may run at the same time as each other, but
// not as a write.
class PlaceIndex {
 public:
  using Excluded = absl::FunctionRef<bool(KeyFrameId)>;

  explicit PlaceIndex(std::shared_ptr<const Vocabulary> vocabulary, const PlaceQueryLimits& limits = {});

  // `words` as Vocabulary::Describe makes them. Replaces what the keyframe had.
  void Add(KeyFrameId keyframe, BagOfWords words);
  // The same for many keyframes, in a fraction of the time where the index is empty so far.
  void AddAll(std::vector<std::pair<KeyFrameId, BagOfWords>> keyframes);
  // Does nothing if it is not there.
  void Remove(KeyFrameId keyframe);
  void Clear();
  // For the queries that follow.
  void SetLimits(const PlaceQueryLimits& limits) { limits_ = limits; }

  // Null if it is not there; valid until the keyframe is removed or replaced.
  const BagOfWords* Find(KeyFrameId keyframe) const;

  // The best `limit` keyframes by falling score, of equal ones the smaller id first. Keyframes of which
  // `excluded` says true, that score below min_score, or that share no word with the query are left out.
  // `excluded` is asked only about keyframes that would otherwise be among the best, in no particular order.
  // Scores and shared words are exact. Which keyframes are compared at all (limits.max_candidates) is decided
  // by sums over postings, whose weights are rounded: to about 0.1 % while all postings are read, and beyond
  // limits.max_postings by the words that say most.
  std::vector<PlaceMatch> Query(const BagOfWords& words, size_t limit, double min_score = 0) const;
  std::vector<PlaceMatch> Query(const BagOfWords& words, size_t limit, double min_score,
                                Excluded excluded) const;

  size_t size() const { return entries_.size(); }
  // Of everything but the vocabulary.
  size_t MemoryBytes() const;
  const Vocabulary& vocabulary() const { return *vocabulary_; }

 private:
  struct Entry {
    uint32_t slot = 0;
    BagOfWords words;
  };
  struct SlotContent {
    KeyFrameId keyframe;
    const BagOfWords* words = nullptr;
  };
  struct Candidate;
  class Search;

  // Those of the bag's words that the vocabulary has: all, unless it was made with another.
  std::span<const WordWeight> KnownWords(const BagOfWords& words) const;
  uint32_t TakeSlot();

  std::shared_ptr<const Vocabulary> vocabulary_;
  PlaceQueryLimits limits_;
  std::unordered_map<KeyFrameId, Entry, IdHash> entries_;  // whose elements stay where they are
  std::vector<SlotContent> slots_;
  std::vector<uint32_t> free_slots_;
  std::vector<std::vector<Posting>> postings_;  // by word, sorted by slot
};

}  // namespace semmap
