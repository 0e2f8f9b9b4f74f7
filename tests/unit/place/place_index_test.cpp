#include "slam/place/place_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <thread>
#include <tuple>

#include "tests/unit/place/place_test_util.h"

namespace semmap {
namespace {

using testing::Perturbed;
using testing::RandomDescriptors;
using testing::RandomVocabulary;

// Looks at every keyframe.
class NaiveIndex {
 public:
  void Add(KeyFrameId keyframe, const BagOfWords& words) { bags_[keyframe] = words; }
  void Remove(KeyFrameId keyframe) { bags_.erase(keyframe); }

  std::vector<PlaceMatch> Query(const BagOfWords& words, size_t limit, double min_score,
                                const std::function<bool(KeyFrameId)>& excluded) const {
    std::vector<PlaceMatch> matches;
    for (const auto& [keyframe, bag] : bags_) {
      PlaceMatch match{keyframe, Similarity(words, bag), 0};
      for (const WordWeight& word : words) {
        match.shared_words += static_cast<int>(std::count_if(
            bag.begin(), bag.end(), [&](const WordWeight& other) { return word.word == other.word; }));
      }
      if (match.shared_words > 0 && match.score >= min_score && !excluded(keyframe)) matches.push_back(match);
    }
    std::sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
      return std::tuple(-a.score, a.keyframe) < std::tuple(-b.score, b.keyframe);
    });
    if (matches.size() > limit) matches.resize(limit);
    return matches;
  }

 private:
  std::map<KeyFrameId, BagOfWords> bags_;
};

// Bags of a few places, several of each, so that scores of all sizes occur.
class Places {
 public:
  explicit Places(std::shared_ptr<const Vocabulary> vocabulary) : vocabulary_(std::move(vocabulary)) {
    for (int i = 0; i < 12; ++i) places_.push_back(RandomDescriptors(60, random_));
  }

  BagOfWords Draw() {
    std::vector<Descriptor> seen = places_[random_() % places_.size()];
    seen.resize(20 + random_() % 40);
    for (Descriptor& descriptor : seen) descriptor = Perturbed(descriptor, 40, random_);
    return vocabulary_->Describe(seen).words;
  }
  uint64_t Random(uint64_t below) { return random_() % below; }

 private:
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::mt19937_64 random_{11};
  std::vector<std::vector<Descriptor>> places_;
};

TEST(PlaceIndex, AgreesWithLookingAtEveryKeyframe) {
  const auto vocabulary = RandomVocabulary(16, 1);
  PlaceIndex index(vocabulary, {1000000, 1000});
  NaiveIndex naive;
  Places places(vocabulary);
  for (int step = 0; step < 1500; ++step) {
    const KeyFrameId keyframe(1 + places.Random(300));
    if (places.Random(4) == 0) {
      index.Remove(keyframe);
      naive.Remove(keyframe);
    } else {
      const BagOfWords words = places.Draw();
      index.Add(keyframe, words);
      naive.Add(keyframe, words);
    }
    if (step % 10 != 0) continue;
    const BagOfWords query = places.Draw();
    const size_t limit = places.Random(20);
    const double min_score = 0.1 * static_cast<double>(places.Random(5));
    const uint64_t divisor = 2 + places.Random(5);
    const auto excluded = [&](KeyFrameId id) { return id.value() % divisor == 0; };
    EXPECT_EQ(index.Query(query, limit, min_score, excluded), naive.Query(query, limit, min_score, excluded));
    EXPECT_EQ(index.Query(query, limit), naive.Query(query, limit, 0, [](KeyFrameId) { return false; }));
  }
}

TEST(PlaceIndex, FindsWhatWasAdded) {
  const auto vocabulary = RandomVocabulary(8, 2);
  PlaceIndex index(vocabulary);
  Places places(vocabulary);
  const BagOfWords first = places.Draw();
  const BagOfWords second = places.Draw();
  index.Add(KeyFrameId(5), first);
  EXPECT_EQ(*index.Find(KeyFrameId(5)), first);
  index.Add(KeyFrameId(5), second);
  EXPECT_EQ(*index.Find(KeyFrameId(5)), second);
  EXPECT_EQ(index.size(), 1U);
  index.Remove(KeyFrameId(5));
  index.Remove(KeyFrameId(5));
  EXPECT_EQ(index.Find(KeyFrameId(5)), nullptr);
  EXPECT_TRUE(index.Query(second, 10).empty());
}

TEST(PlaceIndex, ClearForgetsAll) {
  const auto vocabulary = RandomVocabulary(8, 3);
  PlaceIndex index(vocabulary);
  Places places(vocabulary);
  for (uint64_t i = 1; i < 50; ++i) index.Add(KeyFrameId(i), places.Draw());
  const size_t full = index.MemoryBytes();
  index.Clear();
  EXPECT_EQ(index.size(), 0U);
  EXPECT_LT(index.MemoryBytes(), full);
  EXPECT_TRUE(index.Query(places.Draw(), 10).empty());
  index.Add(KeyFrameId(7), places.Draw());
  EXPECT_EQ(index.Query(*index.Find(KeyFrameId(7)), 10).size(), 1U);
}

TEST(PlaceIndex, EmptyBagsAreKeptAndNeverFound) {
  PlaceIndex index(RandomVocabulary(8, 4));
  index.Add(KeyFrameId(1), {});
  EXPECT_NE(index.Find(KeyFrameId(1)), nullptr);
  EXPECT_TRUE(index.Query({}, 10).empty());
  EXPECT_TRUE(index.Query({{3, 1.0F}}, 10).empty());
}

TEST(PlaceIndex, WordsOfAnotherVocabularyAreLeftOut) {
  PlaceIndex index(RandomVocabulary(2, 5));  // 4 words
  index.Add(KeyFrameId(1), {{3, 0.5F}, {4, 0.5F}});
  EXPECT_EQ(index.Find(KeyFrameId(1))->size(), 1U);
  const auto matches = index.Query({{3, 0.25F}, {1000000, 0.75F}}, 10);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0], (PlaceMatch{KeyFrameId(1), 0.25, 1}));
}

TEST(PlaceIndex, EqualScoresComeBySmallerId) {
  const auto vocabulary = RandomVocabulary(8, 6);
  PlaceIndex index(vocabulary);
  Places places(vocabulary);
  const BagOfWords words = places.Draw();
  for (const uint64_t id : {9, 2, 500, 4, 77}) index.Add(KeyFrameId(id), words);
  const auto matches = index.Query(words, 3);
  ASSERT_EQ(matches.size(), 3U);
  EXPECT_EQ(matches[0].keyframe, KeyFrameId(2));
  EXPECT_EQ(matches[1].keyframe, KeyFrameId(4));
  EXPECT_EQ(matches[2].keyframe, KeyFrameId(9));
}

// Beyond the limits the best is still found where it stands out, and scores stay exact.
TEST(PlaceIndex, StrongMatchSurvivesTightLimits) {
  const auto vocabulary = RandomVocabulary(32, 7);
  PlaceIndex index(vocabulary, {2000, 10});
  std::mt19937_64 random(7);
  std::vector<std::vector<Descriptor>> seen;
  for (uint64_t i = 0; i < 400; ++i) {
    seen.push_back(RandomDescriptors(100, random));
    index.Add(KeyFrameId(i + 1), vocabulary->Describe(seen.back()).words);
  }
  for (uint64_t i = 0; i < 400; i += 20) {
    auto again = seen[i];
    for (Descriptor& descriptor : again) descriptor = Perturbed(descriptor, 10, random);
    const BagOfWords query = vocabulary->Describe(again).words;
    const auto matches = index.Query(query, 3);
    ASSERT_FALSE(matches.empty());
    EXPECT_EQ(matches[0].keyframe, KeyFrameId(i + 1));
    for (const PlaceMatch& match : matches) {
      EXPECT_EQ(match.score, Similarity(query, *index.Find(match.keyframe)));
    }
  }
}

TEST(PlaceIndex, QueriesMayRunAtTheSameTime) {
  const auto vocabulary = RandomVocabulary(16, 8);
  PlaceIndex index(vocabulary);
  Places places(vocabulary);
  for (uint64_t i = 1; i <= 200; ++i) index.Add(KeyFrameId(i), places.Draw());
  const BagOfWords query = places.Draw();
  const auto expected = index.Query(query, 10);
  std::vector<std::vector<PlaceMatch>> found(4);
  {
    std::vector<std::jthread> threads;
    for (auto& matches : found) {
      threads.emplace_back([&] {
        for (int i = 0; i < 20; ++i) matches = index.Query(query, 10);
      });
    }
  }
  for (const auto& matches : found) EXPECT_EQ(matches, expected);
}

TEST(Posting, WeightIsRoundedUpByLessThanAStep) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 1000; ++i) {
    const float weight = std::exp2(-15.0F * static_cast<float>(random() % 10000) / 10000.0F);
    const Posting posting(12345, weight);
    EXPECT_EQ(posting.slot(), 12345U);
    EXPECT_GE(posting.weight(), weight);
    EXPECT_LE(posting.weight(), weight * 1.045F);
  }
  EXPECT_GE(Posting(Posting::kMaxSlots - 1, 1e-9F).weight(), 1e-9F);
  EXPECT_EQ(Posting(Posting::kMaxSlots - 1, 1.0F).slot(), Posting::kMaxSlots - 1);
  EXPECT_EQ(Posting(0, 1.0F).weight(), 1.0F);
}

}  // namespace
}  // namespace semmap
