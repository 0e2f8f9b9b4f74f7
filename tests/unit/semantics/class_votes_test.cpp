#include "slam/semantics/class_votes.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

ClassVotes Votes(const std::vector<uint8_t>& classes) {
  ClassVotes votes;
  for (const uint8_t semantic_class : classes) votes.Add(semantic_class);
  return votes;
}

TEST(ClassVotesTest, MostFrequentWins) {
  const ClassVotes votes = Votes({1, 10, 10, 7, 10, 1});
  EXPECT_EQ(votes.MostFrequent(), 10);
  EXPECT_EQ(votes.First(), 1);
  EXPECT_EQ(votes.total(), 6U);
  EXPECT_FLOAT_EQ(votes.ShareOf(10), 0.5F);
  EXPECT_FLOAT_EQ(votes.ShareOf(22), 0.0F);
}

TEST(ClassVotesTest, AmongEqualsTheFirstSeenStays) {
  EXPECT_EQ(Votes({10, 1}).MostFrequent(), 10);
  EXPECT_EQ(Votes({1, 10}).MostFrequent(), 1);
  EXPECT_EQ(Votes({1, 10, 10}).MostFrequent(), 10);
}

TEST(ClassVotesTest, WithoutVotesNothingIsKnown) {
  const ClassVotes none = Votes({kUnknownClass, kUnknownClass});
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.MostFrequent(), kUnknownClass);
  EXPECT_EQ(none.First(), kUnknownClass);
  EXPECT_EQ(none.ShareOf(kUnknownClass), 0);
}

TEST(ClassVotesTest, VotesAreTakenBackOneByOne) {
  ClassVotes votes = Votes({1, 1, 10});
  votes.Remove(1);
  EXPECT_EQ(votes.ToVector(), (std::vector<ClassVote>{{1, 1}, {10, 1}}));
  votes.Remove(1);
  EXPECT_EQ(votes.First(), 10);
  votes.Remove(7);
  votes.Remove(kUnknownClass);
  EXPECT_EQ(votes.total(), 1U);
}

TEST(ClassVotesTest, AddsUpAndComesBackFromRecords) {
  ClassVotes votes = Votes({1, 10});
  votes.Add(Votes({10, 7}));
  EXPECT_EQ(votes.ToVector(), (std::vector<ClassVote>{{1, 1}, {10, 2}, {7, 1}}));
  EXPECT_EQ(ClassVotes(votes.ToVector()).ToVector(), votes.ToVector());
  EXPECT_TRUE(ClassVotes(std::vector<ClassVote>{{kUnknownClass, 5}, {3, 0}}).empty());
}

TEST(PointClassPolicyTest, ChoosesByMajorityOrByTheFirst) {
  const ClassVotes votes = Votes({1, 10, 10});
  PointClassPolicy policy{true, ClassSet(kInactiveClasses)};
  EXPECT_EQ(policy.ClassOf(votes), 10);
  EXPECT_FALSE(policy.IsActive(policy.ClassOf(votes)));
  policy.majority = false;
  EXPECT_EQ(policy.ClassOf(votes), 1);
  EXPECT_TRUE(policy.IsActive(kUnknownClass));
}

}  // namespace
}  // namespace semmap
