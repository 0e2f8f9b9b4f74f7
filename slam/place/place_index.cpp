#include "slam/place/place_index.h"

#include <algorithm>
#include <utility>

namespace semmap {
namespace {

// Where the posting of a slot is or belongs.
auto PositionOf(uint32_t slot, std::vector<Posting>& postings) {
  return std::lower_bound(postings.begin(), postings.end(), slot,
                          [](Posting posting, uint32_t wanted) { return posting.slot() < wanted; });
}

// Almost always at the end: a slot in between is one that was given back.
void Insert(Posting posting, std::vector<Posting>* postings) {
  if (postings->empty() || postings->back().slot() < posting.slot()) {
    postings->push_back(posting);
  } else {
    postings->insert(PositionOf(posting.slot(), *postings), posting);
  }
}

}  // namespace

PlaceIndex::PlaceIndex(std::shared_ptr<const Vocabulary> vocabulary, const PlaceQueryLimits& limits)
    : vocabulary_(std::move(vocabulary)), limits_(limits), postings_(vocabulary_->words()) {}

std::span<const WordWeight> PlaceIndex::KnownWords(const BagOfWords& words) const {
  const auto end = std::partition_point(
      words.begin(), words.end(), [this](const WordWeight& word) { return word.word < postings_.size(); });
  return {words.begin(), end};
}

uint32_t PlaceIndex::TakeSlot() {
  if (free_slots_.empty()) {
    slots_.emplace_back();
    return static_cast<uint32_t>(slots_.size() - 1);
  }
  const uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

void PlaceIndex::Add(KeyFrameId keyframe, BagOfWords words) {
  Remove(keyframe);
  Entry& entry = entries_[keyframe];
  entry.slot = TakeSlot();
  words.resize(KnownWords(words).size());
  entry.words = std::move(words);
  entry.words.shrink_to_fit();
  slots_[entry.slot] = {keyframe, &entry.words};
  for (const WordWeight& word : entry.words) Insert(Posting(entry.slot, word.weight), &postings_[word.word]);
}

void PlaceIndex::AddAll(std::vector<std::pair<KeyFrameId, BagOfWords>> keyframes) {
  // Each list gets its memory at once: grown one by one, they cost more than all else.
  std::vector<uint32_t> counts(postings_.size(), 0);
  for (const auto& [id, words] : keyframes) {
    for (const WordWeight& word : KnownWords(words)) ++counts[word.word];
  }
  for (size_t word = 0; word < counts.size(); ++word) {
    if (counts[word] > 0) postings_[word].reserve(postings_[word].size() + counts[word]);
  }
  entries_.reserve(entries_.size() + keyframes.size());
  slots_.reserve(slots_.size() + keyframes.size());
  for (auto& [id, words] : keyframes) Add(id, std::move(words));
}

void PlaceIndex::Remove(KeyFrameId keyframe) {
  const auto found = entries_.find(keyframe);
  if (found == entries_.end()) return;
  const uint32_t slot = found->second.slot;
  for (const WordWeight& word : found->second.words) {
    std::vector<Posting>& postings = postings_[word.word];
    postings.erase(PositionOf(slot, postings));
  }
  slots_[slot] = {};
  free_slots_.push_back(slot);
  entries_.erase(found);
}

void PlaceIndex::Clear() {
  entries_.clear();
  slots_.clear();
  free_slots_.clear();
  postings_.assign(vocabulary_->words(), {});
}

const BagOfWords* PlaceIndex::Find(KeyFrameId keyframe) const {
  const auto found = entries_.find(keyframe);
  return found == entries_.end() ? nullptr : &found->second.words;
}

size_t PlaceIndex::MemoryBytes() const {
  // A hash node also has its link, and each bucket one pointer.
  size_t bytes = entries_.size() * (sizeof(*entries_.begin()) + sizeof(void*)) +
                 entries_.bucket_count() * sizeof(void*) + slots_.capacity() * sizeof(SlotContent) +
                 free_slots_.capacity() * sizeof(uint32_t) +
                 postings_.capacity() * sizeof(std::vector<Posting>);
  for (const auto& [keyframe, entry] : entries_) bytes += entry.words.capacity() * sizeof(WordWeight);
  for (const std::vector<Posting>& postings : postings_) bytes += postings.capacity() * sizeof(Posting);
  return bytes;
}

}  // namespace semmap
