#include <algorithm>
#include <span>
#include <tuple>

#include "slam/place/place_index.h"

// A query in three steps: postings are added up to a bound on each keyframe's similarity, the keyframes with
// the greatest bounds are selected, and their similarity is computed in full until no other can be among the
// best.
namespace semmap {
namespace {

// Share by which the sum of a few thousand floats may lie below what it should be.
constexpr float kRounding = 1e-4F;
// How many lists of postings ahead the first entries of one are fetched: lists are short and lie far apart.
constexpr size_t kListsAhead = 8;

// Arrays that are all zero between queries; each thread has its own, so that queries share nothing.
struct Scratch {
  std::vector<float> bounds;   // by slot
  std::vector<float> weights;  // by word: the query's
};
thread_local Scratch scratch;

void GrowTo(size_t size, std::vector<float>* values) {
  if (values->size() < size) values->resize(size, 0.0F);
}

bool Better(const PlaceMatch& a, const PlaceMatch& b) {
  return std::tuple(-a.score, a.keyframe) < std::tuple(-b.score, b.keyframe);
}

}  // namespace

struct PlaceIndex::Candidate {
  float bound = 0;  // what was added up from postings
  KeyFrameId keyframe;
  uint32_t slot = 0;

  friend bool Better(const Candidate& a, const Candidate& b) {
    return std::tuple(-a.bound, a.keyframe) < std::tuple(-b.bound, b.keyframe);
  }
};

class PlaceIndex::Search {
 public:
  Search(const PlaceIndex& index, const BagOfWords& words, Excluded excluded);
  ~Search();
  Search(const Search&) = delete;
  Search& operator=(const Search&) = delete;

  std::vector<PlaceMatch> Best(size_t limit, double min_score) const;

 private:
  struct Word {
    const std::vector<Posting>* postings;
    float weight;
  };

  std::vector<Word> WordsWithPostings() const;
  void AddUp(std::vector<Word> words);
  void AddUp(const Word& word);
  std::vector<Candidate> MostPromising(size_t count, double min_score) const;
  PlaceMatch Compare(const Candidate& candidate) const;
  // The similarity is not above this.
  double CeilingOf(const Candidate& candidate) const { return candidate.bound * (1 + kRounding) + left_out_; }

  const PlaceIndex& index_;
  std::span<const WordWeight> query_;
  Excluded excluded_;
  std::vector<float>& bounds_ = scratch.bounds;
  std::vector<float>& weights_ = scratch.weights;
  double left_out_ = 0;  // weight of the words whose postings were not read
};

PlaceIndex::Search::Search(const PlaceIndex& index, const BagOfWords& words, Excluded excluded)
    : index_(index), query_(index.KnownWords(words)), excluded_(excluded) {
  GrowTo(index_.slots_.size(), &bounds_);
  GrowTo(index_.postings_.size(), &weights_);
  for (const WordWeight& word : query_) weights_[word.word] = word.weight;
  AddUp(WordsWithPostings());
}

PlaceIndex::Search::~Search() {
  std::fill_n(bounds_.begin(), index_.slots_.size(), 0.0F);
  for (const WordWeight& word : query_) weights_[word.word] = 0;
}

std::vector<PlaceIndex::Search::Word> PlaceIndex::Search::WordsWithPostings() const {
  std::vector<Word> words;
  words.reserve(query_.size());
  for (const WordWeight& word : query_) {
    const std::vector<Posting>& postings = index_.postings_[word.word];
    if (!postings.empty()) words.push_back({&postings, word.weight});
  }
  return words;
}

// Reads as many postings as is allowed. Frequent words are long to read and say little: they are left out
// first.
void PlaceIndex::Search::AddUp(std::vector<Word> words) {
  const auto allowed = static_cast<size_t>(index_.limits_.max_postings);
  size_t total = 0;
  for (const Word& word : words) total += word.postings->size();
  if (total > allowed) {
    std::stable_sort(words.begin(), words.end(), [](const Word& a, const Word& b) {
      return static_cast<float>(a.postings->size()) * b.weight <
             static_cast<float>(b.postings->size()) * a.weight;
    });
  }
  size_t read = 0;
  for (size_t i = 0; i < words.size(); ++i) {
    if (i + kListsAhead < words.size()) __builtin_prefetch(words[i + kListsAhead].postings->data());
    const size_t size = words[i].postings->size();
    if (read > 0 && read + size > allowed) {
      left_out_ += words[i].weight;
      continue;
    }
    read += size;
    AddUp(words[i]);
  }
}

void PlaceIndex::Search::AddUp(const Word& word) {
  float* bounds = bounds_.data();
  for (const Posting posting : *word.postings) {
    bounds[posting.slot()] += std::min(word.weight, posting.weight());
  }
}

// The `count` keyframes of greatest bound, best first.
std::vector<PlaceIndex::Candidate> PlaceIndex::Search::MostPromising(size_t count, double min_score) const {
  const auto better = [](const Candidate& a, const Candidate& b) { return Better(a, b); };
  std::vector<Candidate> heap;  // the worst on top
  float floor = static_cast<float>((min_score - left_out_) / (1 + kRounding));
  for (uint32_t slot = 0; slot < index_.slots_.size(); ++slot) {
    const float bound = bounds_[slot];
    if (bound < floor || bound == 0) continue;
    const Candidate candidate{bound, index_.slots_[slot].keyframe, slot};
    if (heap.size() == count && !Better(candidate, heap.front())) continue;
    if (excluded_(candidate.keyframe)) continue;
    if (heap.size() == count) {
      std::pop_heap(heap.begin(), heap.end(), better);
      heap.pop_back();
    }
    heap.push_back(candidate);
    std::push_heap(heap.begin(), heap.end(), better);
    if (heap.size() == count) floor = heap.front().bound;
  }
  std::sort_heap(heap.begin(), heap.end(), better);
  return heap;
}

PlaceMatch PlaceIndex::Search::Compare(const Candidate& candidate) const {
  PlaceMatch match;
  match.keyframe = candidate.keyframe;
  for (const WordWeight& word : *index_.slots_[candidate.slot].words) {
    const float weight = weights_[word.word];
    match.score += std::min(weight, word.weight);
    match.shared_words += weight > 0 ? 1 : 0;
  }
  return match;
}

std::vector<PlaceMatch> PlaceIndex::Search::Best(size_t limit, double min_score) const {
  std::vector<PlaceMatch> best;  // a heap, the worst on top
  if (limit == 0) return best;
  double floor = min_score;
  const size_t count = std::max<size_t>(limit, index_.limits_.max_candidates);
  for (const Candidate& candidate : MostPromising(std::min(count, index_.size()), min_score)) {
    // Neither this nor any that follows can be among the best.
    if (CeilingOf(candidate) < floor) break;
    const PlaceMatch match = Compare(candidate);
    if (match.score < min_score) continue;
    best.push_back(match);
    std::push_heap(best.begin(), best.end(), Better);
    if (best.size() > limit) {
      std::pop_heap(best.begin(), best.end(), Better);
      best.pop_back();
    }
    if (best.size() == limit) floor = best.front().score;
  }
  std::sort_heap(best.begin(), best.end(), Better);
  return best;
}

std::vector<PlaceMatch> PlaceIndex::Query(const BagOfWords& words, size_t limit, double min_score) const {
  return Query(words, limit, min_score, [](KeyFrameId) { return false; });
}

std::vector<PlaceMatch> PlaceIndex::Query(const BagOfWords& words, size_t limit, double min_score,
                                          Excluded excluded) const {
  return Search(*this, words, excluded).Best(limit, min_score);
}

}  // namespace semmap
