#include "slam/place/place_description.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/unit/place/place_test_util.h"

namespace semmap {
namespace {

// As the paper writes it.
double SimilarityFromL1Norm(const BagOfWords& a, const BagOfWords& b) {
  std::map<WordId, double> difference;
  for (const WordWeight& word : a) difference[word.word] += word.weight;
  for (const WordWeight& word : b) difference[word.word] -= word.weight;
  double norm = 0;
  for (const auto& [word, value] : difference) norm += std::abs(value);
  return 1 - 0.5 * norm;
}

TEST(Similarity, IsThePapersEquation) {
  const auto vocabulary = testing::RandomVocabulary(8, 1);
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    const BagOfWords a = vocabulary->Describe(testing::RandomDescriptors(50, random)).words;
    const BagOfWords b = vocabulary->Describe(testing::RandomDescriptors(70, random)).words;
    EXPECT_NEAR(Similarity(a, b), SimilarityFromL1Norm(a, b), 1e-6);
    EXPECT_EQ(Similarity(a, b), Similarity(b, a));
    EXPECT_NEAR(Similarity(a, a), 1.0, 1e-5);
  }
}

TEST(Similarity, OfNothingInCommonIsZero) {
  const BagOfWords a = {{1, 0.5F}, {4, 0.5F}};
  const BagOfWords b = {{2, 0.5F}, {3, 0.5F}};
  EXPECT_EQ(Similarity(a, b), 0.0);
  EXPECT_EQ(Similarity(a, {}), 0.0);
  EXPECT_EQ(Similarity({}, {}), 0.0);
}

TEST(Similarity, CountsTheSmallerWeight) {
  EXPECT_DOUBLE_EQ(Similarity({{1, 0.25F}, {4, 0.75F}}, {{1, 0.5F}, {9, 0.5F}}), 0.25);
}

}  // namespace
}  // namespace semmap
