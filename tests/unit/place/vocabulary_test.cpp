#include "slam/place/vocabulary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "tests/unit/place/place_test_util.h"

namespace semmap {
namespace {

using testing::RandomDescriptors;
using testing::RandomTree;
using testing::RandomVocabulary;

// Descends as the header says, written once more in the plainest way.
uint32_t NaiveLeaf(const VocabularyTree& tree, const Descriptor& descriptor, uint32_t* child_of_root) {
  uint32_t node = 0;
  while (!tree.nodes[node].IsLeaf()) {
    const VocabularyNode& parent = tree.nodes[node];
    uint32_t best = parent.first;
    for (uint32_t child = parent.first; child < parent.first + parent.children; ++child) {
      if (HammingDistance(descriptor, tree.centres[child]) <
          HammingDistance(descriptor, tree.centres[best])) {
        best = child;
      }
    }
    if (node == 0) *child_of_root = best;
    node = best;
  }
  return node;
}

TEST(Vocabulary, WordsAndGroupsAreThoseOfTheNearestCentres) {
  const VocabularyTree tree = RandomTree(11, 1);
  std::mt19937_64 random(2);
  const auto descriptors = RandomDescriptors(500, random);
  const PlaceDescription place = RandomVocabulary(11, 1)->Describe(descriptors);
  std::map<WordId, double> expected;
  std::map<uint32_t, std::vector<uint32_t>> groups;
  double sum = 0;
  for (uint32_t i = 0; i < descriptors.size(); ++i) {
    uint32_t child_of_root = 0;
    const WordId word = tree.nodes[NaiveLeaf(tree, descriptors[i], &child_of_root)].first;
    expected[word] += tree.idf[word];
    sum += tree.idf[word];
    groups[child_of_root].push_back(i);
  }
  ASSERT_EQ(place.words.size(), expected.size());
  for (const WordWeight& word : place.words) EXPECT_NEAR(word.weight, expected.at(word.word) / sum, 1e-7);
  ASSERT_EQ(place.nodes.groups.size(), groups.size());
  auto group = groups.begin();
  for (const NodeGroup& found : place.nodes.groups) {
    EXPECT_EQ(found.node, group->first);
    const auto begin = place.nodes.keypoints.begin();
    EXPECT_EQ(std::vector(begin + found.begin, begin + found.end), group->second);
    ++group;
  }
}

TEST(Vocabulary, BagIsSortedAndSumsToOne) {
  std::mt19937_64 random(3);
  const BagOfWords bag = RandomVocabulary(10, 3)->Describe(RandomDescriptors(300, random)).words;
  EXPECT_TRUE(std::is_sorted(bag.begin(), bag.end(), [](auto& a, auto& b) { return a.word < b.word; }));
  EXPECT_NEAR(std::accumulate(bag.begin(), bag.end(), 0.0, [](double s, auto& w) { return s + w.weight; }),
              1.0, 1e-5);
}

TEST(Vocabulary, OrderOfDescriptorsDoesNotMatter) {
  const auto vocabulary = RandomVocabulary(10, 4);
  std::mt19937_64 random(4);
  auto descriptors = RandomDescriptors(300, random);
  const PlaceDescription before = vocabulary->Describe(descriptors);
  EXPECT_EQ(before, vocabulary->Describe(descriptors));
  std::vector<uint32_t> position(descriptors.size());  // where each went
  std::iota(position.begin(), position.end(), 0);
  std::shuffle(position.begin(), position.end(), random);
  std::vector<Descriptor> shuffled(descriptors.size());
  for (size_t i = 0; i < position.size(); ++i) shuffled[position[i]] = descriptors[i];
  const PlaceDescription after = vocabulary->Describe(shuffled);
  EXPECT_EQ(before.words, after.words);
  EXPECT_EQ(before.nodes.groups, after.nodes.groups);
  for (const NodeGroup& group : before.nodes.groups) {
    std::vector<uint32_t> moved;
    for (uint32_t i = group.begin; i < group.end; ++i) moved.push_back(position[before.nodes.keypoints[i]]);
    std::sort(moved.begin(), moved.end());
    EXPECT_TRUE(std::equal(moved.begin(), moved.end(), after.nodes.keypoints.begin() + group.begin));
  }
}

TEST(Vocabulary, WordsThatSayNothingAreLeftOut) {
  VocabularyTree tree = RandomTree(4, 5);
  std::fill(tree.idf.begin(), tree.idf.end(), 0.0F);
  tree.idf[7] = 0.5F;
  const auto vocabulary = Vocabulary::FromTree(tree).value();
  std::mt19937_64 random(5);
  const BagOfWords bag = vocabulary->Describe(RandomDescriptors(300, random)).words;
  ASSERT_EQ(bag.size(), 1U);
  EXPECT_EQ(bag[0], (WordWeight{7, 1.0F}));
}

TEST(Vocabulary, NothingSeenGivesNothing) {
  EXPECT_EQ(RandomVocabulary(4, 6)->Describe({}), PlaceDescription());
}

TEST(Vocabulary, LeafAboveTheDirectLevelIsAGroupOfItsOwn) {
  VocabularyTree tree;
  tree.branching = 2;
  tree.levels = 2;
  tree.direct_level = 2;
  tree.nodes = {{1, 2}, {0, 0}, {3, 2}, {1, 0}, {2, 0}};
  tree.centres.resize(5);
  tree.centres[2].words = {~0ULL, ~0ULL, ~0ULL, ~0ULL};
  tree.centres[3].words = {~0ULL, ~0ULL, ~0ULL, 0};
  tree.centres[4].words = {~0ULL, ~0ULL, ~0ULL, ~0ULL};
  tree.idf = {1, 1, 1};
  const auto vocabulary = Vocabulary::FromTree(tree).value();
  const std::vector<Descriptor> descriptors = {tree.centres[4], tree.centres[1], tree.centres[3]};
  const PlaceDescription place = vocabulary->Describe(descriptors);
  EXPECT_EQ(place.nodes.groups, (std::vector<NodeGroup>{{1, 0, 1}, {3, 1, 2}, {4, 2, 3}}));
  EXPECT_EQ(place.nodes.keypoints, (std::vector<uint32_t>{1, 2, 0}));
}

TEST(Vocabulary, IdDependsOnContent) {
  EXPECT_EQ(RandomVocabulary(5, 1)->id(), RandomVocabulary(5, 1)->id());
  EXPECT_NE(RandomVocabulary(5, 1)->id(), RandomVocabulary(5, 2)->id());
}

}  // namespace
}  // namespace semmap
