#include "slam/place/vocabulary_trainer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "slam/place/hamming_medians.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap {
namespace {

using testing::Perturbed;
using testing::RandomDescriptor;
using testing::RandomDescriptors;

std::vector<Descriptor> Around(const std::vector<Descriptor>& centres, int each, int flips, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Descriptor> points;
  for (int i = 0; i < each; ++i) {
    for (const Descriptor& centre : centres) points.push_back(Perturbed(centre, flips, random));
  }
  return points;
}

TEST(ClusterByMedians, FindsWellSeparatedClusters) {
  std::mt19937_64 random(1);
  const auto centres = RandomDescriptors(8, random);
  const auto points = Around(centres, 101, 25, 2);
  const Medians medians = ClusterByMedians(points, {8, 20, 3});
  ASSERT_EQ(medians.centres.size(), 8U);
  for (size_t i = 0; i < points.size(); ++i) {
    // Noise averages out: the majority is the centre that the points were scattered around.
    EXPECT_EQ(medians.centres[medians.cluster_of[i]], centres[i % 8]);
  }
}

TEST(ClusterByMedians, EachPointIsWithItsNearestCentre) {
  std::mt19937_64 random(4);
  const auto points = RandomDescriptors(300, random);
  const Medians medians = ClusterByMedians(points, {7, 3, 5});
  for (size_t i = 0; i < points.size(); ++i) {
    const int own = HammingDistance(points[i], medians.centres[medians.cluster_of[i]]);
    for (const Descriptor& centre : medians.centres) EXPECT_LE(own, HammingDistance(points[i], centre));
  }
}

TEST(ClusterByMedians, HasNoMoreClustersThanDifferentPoints) {
  std::mt19937_64 random(6);
  const Descriptor one = RandomDescriptor(random);
  const Descriptor other = RandomDescriptor(random);
  const std::vector<Descriptor> points = {one, other, one, one, other};
  const Medians medians = ClusterByMedians(points, {4, 10, 1});
  EXPECT_EQ(medians.centres.size(), 2U);
  EXPECT_EQ(medians.centres[medians.cluster_of[0]], one);
  EXPECT_EQ(medians.centres[medians.cluster_of[4]], other);
  EXPECT_EQ(ClusterByMedians(std::vector<Descriptor>{one}, {4, 10, 1}).centres.size(), 1U);
}

// Four families of four kinds each, and images that each show one family and every kind of it.
class TrainedOnFamilies : public ::testing::Test {
 protected:
  TrainedOnFamilies() {
    std::mt19937_64 random(7);
    for (const Descriptor& family : RandomDescriptors(4, random)) {
      std::vector<Descriptor> kinds;
      for (int i = 0; i < 4; ++i) kinds.push_back(Perturbed(family, 20, random));
      for (int image = 0; image < 10; ++image) images_.push_back(Around(kinds, 5, 3, random()));
    }
  }

  VocabularyTrainingConfig config_{4, 2, 1, 20, 20, 1};
  std::vector<std::vector<Descriptor>> images_;
};

TEST_F(TrainedOnFamilies, FindsFamiliesAndKinds) {
  const auto tree = TrainVocabulary(images_, config_);
  ASSERT_TRUE(tree.ok()) << tree.status();
  EXPECT_EQ(tree->idf.size(), 16U);
  const auto vocabulary = Vocabulary::FromTree(*tree).value();
  std::set<uint32_t> families;
  std::set<WordId> words;
  for (size_t image = 0; image < images_.size(); image += 10) {
    const PlaceDescription place = vocabulary->Describe(images_[image]);
    ASSERT_EQ(place.nodes.groups.size(), 1U);
    families.insert(place.nodes.groups[0].node);
    EXPECT_EQ(place.words.size(), 4U);
    for (const WordWeight& word : place.words) {
      words.insert(word.word);
      EXPECT_FLOAT_EQ(word.weight, 0.25F);
      // Each kind is in the ten images of its family, of forty.
      EXPECT_FLOAT_EQ(tree->idf[word.word], std::log(4.0F));
    }
  }
  EXPECT_EQ(families.size(), 4U);
  EXPECT_EQ(words.size(), 16U);
}

TEST_F(TrainedOnFamilies, IsTheSameForTheSameSeed) {
  const auto first = TrainVocabulary(images_, config_);
  const auto second = TrainVocabulary(images_, config_);
  EXPECT_EQ(first->nodes, second->nodes);
  EXPECT_EQ(first->centres, second->centres);
  EXPECT_EQ(first->idf, second->idf);
}

TEST_F(TrainedOnFamilies, TellsItsProgress) {
  std::vector<size_t> nodes;
  ASSERT_TRUE(TrainVocabulary(images_, config_, [&](int level, size_t count) {
                EXPECT_EQ(static_cast<size_t>(level), nodes.size() + 1);
                nodes.push_back(count);
              }).ok());
  EXPECT_EQ(nodes, (std::vector<size_t>{4, 16}));
}

TEST_F(TrainedOnFamilies, SmallNodesAreLeaves) {
  config_.min_descriptors = 300;  // a family has 200
  const auto tree = TrainVocabulary(images_, config_);
  EXPECT_EQ(tree->idf.size(), 4U);
}

TEST_F(TrainedOnFamilies, WordThatEveryImageHasWeighsNothing) {
  std::mt19937_64 random(8);
  const Descriptor everywhere = RandomDescriptor(random);
  for (auto& image : images_) image.insert(image.end(), 30, everywhere);
  config_.branching = 5;
  const auto tree = TrainVocabulary(images_, config_);
  ASSERT_TRUE(tree.ok());
  EXPECT_EQ(std::count(tree->idf.begin(), tree->idf.end(), 0.0F), 1);
}

TEST(TrainVocabulary, RefusesSettingsOutOfBoundsAndNothingToLearn) {
  const std::vector<std::vector<Descriptor>> images(1, std::vector<Descriptor>(1));
  EXPECT_TRUE(TrainVocabulary(images, {}).ok());
  EXPECT_TRUE(absl::IsInvalidArgument(TrainVocabulary({}, {}).status()));
  for (const VocabularyTrainingConfig& config :
       {VocabularyTrainingConfig{1, 5, 2}, VocabularyTrainingConfig{257, 5, 2},
        VocabularyTrainingConfig{10, 0, 0}, VocabularyTrainingConfig{10, 9, 2},
        VocabularyTrainingConfig{10, 5, 6}, VocabularyTrainingConfig{10, 5, -1}}) {
    EXPECT_TRUE(absl::IsInvalidArgument(TrainVocabulary(images, config).status()));
  }
}

}  // namespace
}  // namespace semmap
