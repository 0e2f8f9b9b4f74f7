#include "slam/pipeline/association.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

Descriptor WithBits(int count) {
  Descriptor descriptor;
  for (int i = 0; i < count; ++i) descriptor.words[i / 64] |= uint64_t{1} << (i % 64);
  return descriptor;
}

Keypoint OfClass(uint8_t semantic_class, uint8_t beside = kUnknownClass) {
  Keypoint keypoint;
  keypoint.semantic_class = semantic_class;
  keypoint.class_beside = beside;
  return keypoint;
}

class AssociationTest : public ::testing::Test {
 protected:
  void Add(float x, float y, int octave, int bits, uint8_t semantic_class = kUnknownClass) {
    Keypoint keypoint;
    keypoint.x = x;
    keypoint.y = y;
    keypoint.octave = static_cast<uint8_t>(octave);
    keypoint.semantic_class = semantic_class;
    features_.keypoints.push_back(keypoint);
    features_.descriptors.push_back(WithBits(bits));
  }

  WindowMatch Find(float x, float y, float radius, int min_octave, int max_octave) {
    grid_.Assign(ImageBounds{0, 0, 640, 480}, features_.keypoints);
    const Descriptor wanted;
    const WindowQuery query{x, y, radius, min_octave, max_octave, -1, &wanted, wanted_class_};
    return FindInWindow(rule_, {features_, grid_}, query, [](int) { return true; });
  }

  AssociationRule rule_;
  uint8_t wanted_class_ = kUnknownClass;
  FrameFeatures features_;
  FeatureGrid grid_;
};

TEST_F(AssociationTest, FindsTheClosestDescriptorInTheWindow) {
  Add(100, 100, 0, 30);
  Add(103, 101, 0, 10);
  Add(140, 100, 0, 0);
  const WindowMatch match = Find(100, 100, 10, 0, 7);
  EXPECT_EQ(match.keypoint, 1);
  EXPECT_EQ(match.distance, 10);
  EXPECT_EQ(match.second_distance, 30);
  EXPECT_TRUE(match.IsDistinct(0.8));
  EXPECT_FALSE(match.IsDistinct(0.3));
}

TEST_F(AssociationTest, OctavesAndEmptyWindowsAreRespected) {
  Add(100, 100, 3, 0);
  EXPECT_EQ(Find(100, 100, 10, 0, 2).keypoint, -1);
  EXPECT_EQ(Find(100, 100, 10, 2, 4).keypoint, 0);
  EXPECT_EQ(Find(300, 300, 10, 0, 7).keypoint, -1);
}

TEST_F(AssociationTest, AnotherClassLosesAgainstTheOwn) {
  wanted_class_ = 1;
  Add(100, 100, 0, 20, 10);
  Add(103, 101, 0, 28, 1);
  EXPECT_EQ(Find(100, 100, 10, 0, 7).keypoint, 0) << "without a rule classes do not matter";
  rule_ = AssociationRule(SemanticsConfig());
  const WindowMatch match = Find(100, 100, 10, 0, 7);
  EXPECT_EQ(match.keypoint, 1);
  EXPECT_EQ(match.second_distance, 30);
}

TEST(AssociationRuleTest, DifferentKnownClassesAreHalfAsFarAgain) {
  const AssociationRule rule((SemanticsConfig()));
  const Descriptor zero;
  EXPECT_EQ(rule.Distance(zero, 1, WithBits(40), OfClass(1)), 40);
  EXPECT_EQ(rule.Distance(zero, 1, WithBits(40), OfClass(10)), 60);
  EXPECT_EQ(rule.Distance(zero, 1, WithBits(40), OfClass(kUnknownClass)), 40);
  EXPECT_EQ(rule.Distance(zero, kUnknownClass, WithBits(40), OfClass(10)), 40);
  EXPECT_TRUE(rule.Matters(1));
  EXPECT_FALSE(rule.Matters(kUnknownClass));
}

TEST(AssociationRuleTest, WhereTwoClassesMeetEitherMatches) {
  const AssociationRule rule((SemanticsConfig()));
  const Descriptor zero;
  EXPECT_EQ(rule.Distance(zero, 1, WithBits(40), OfClass(10, 1)), 40);
  EXPECT_EQ(rule.Distance(zero, 1, WithBits(40), OfClass(10, 7)), 60);
  EXPECT_EQ(rule.Distance(zero, OfClass(1, 7), WithBits(40), OfClass(7)), 40);
  EXPECT_EQ(rule.Distance(zero, OfClass(1, 7), WithBits(40), OfClass(10, 7)), 40);
  EXPECT_EQ(rule.Distance(zero, OfClass(1, 7), WithBits(40), OfClass(10)), 60);
  EXPECT_EQ(rule.Distance(zero, OfClass(1), WithBits(40), OfClass(10, 1)), 40);
}

TEST(AssociationRuleTest, StrictNeverMatchesAcrossClasses) {
  SemanticsConfig config;
  config.strict = true;
  config.penalty = 0;
  const AssociationRule rule(config);
  const Descriptor zero;
  EXPECT_EQ(rule.Distance(zero, 1, zero, OfClass(10)), kNoDistance);
  EXPECT_EQ(rule.Distance(zero, 1, zero, OfClass(1)), 0);
  EXPECT_TRUE(rule.Matters(1));
}

TEST(AssociationRuleTest, SwitchedOffClassesDoNotMatter) {
  SemanticsConfig config;
  config.strict = true;
  config.enabled = false;
  for (const AssociationRule& rule : {AssociationRule(config), AssociationRule()}) {
    EXPECT_EQ(rule.Distance(Descriptor(), 1, WithBits(40), OfClass(10)), 40);
    EXPECT_FALSE(rule.Matters(1));
  }
}

TEST_F(AssociationTest, RunnerUpOfAnotherScaleDoesNotCompete) {
  Add(100, 100, 0, 10);
  Add(101, 100, 1, 11);
  EXPECT_TRUE(Find(100, 100, 10, 0, 7).IsDistinct(0.5));
}

TEST(KeepBestOfSecondTest, OneFirstForEachSecond) {
  std::vector<KeypointPair> pairs = {{0, 5, 30}, {1, 5, 20}, {2, 6, 40}, {3, 5, 20}};
  KeepBestOfSecond(8, &pairs);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].first, 1);
  EXPECT_EQ(pairs[1].first, 2);
}

TEST(KeepConsistentRotationTest, DropsWhatTurnsOtherwise) {
  std::vector<Keypoint> first(20);
  std::vector<Keypoint> second(20);
  std::vector<KeypointPair> pairs;
  for (int i = 0; i < 20; ++i) {
    first[i].angle = 0.3F * static_cast<float>(i);
    second[i].angle = first[i].angle + (i % 5 == 0 ? 2.0F : 6.2F);
    pairs.push_back({i, i, 0});
  }
  KeepConsistentRotation(first, second, &pairs);
  EXPECT_EQ(pairs.size(), 16U);
  for (const KeypointPair& pair : pairs) EXPECT_NE(pair.first % 5, 0);
}

}  // namespace
}  // namespace semmap
