#include "slam/features/descriptor_search.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace semmap {
namespace {

// Near each other, so that distances tie often.
std::vector<Descriptor> SimilarDescriptors(size_t count, uint32_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (uint64_t& word : descriptor.words) word = random() & random() & random();
  }
  return descriptors;
}

NearestTwo BySorting(const Descriptor& query, const std::vector<Descriptor>& candidates) {
  std::vector<std::pair<int, int>> order;
  for (size_t i = 0; i < candidates.size(); ++i) {
    order.emplace_back(HammingDistance(query, candidates[i]), static_cast<int>(i));
  }
  std::sort(order.begin(), order.end());
  NearestTwo nearest;
  if (!order.empty()) {
    nearest.distance = order[0].first;
    nearest.index = order[0].second;
  }
  if (order.size() > 1) nearest.second_distance = order[1].first;
  return nearest;
}

TEST(DescriptorSearch, FindsWhatSortingFinds) {
  const auto queries = SimilarDescriptors(200, 1);
  for (const size_t count : {0, 1, 2, 7, 8, 9, 15, 16, 17, 100, 1003}) {
    const auto candidates = SimilarDescriptors(count, static_cast<uint32_t>(count));
    for (const Descriptor& query : queries) {
      ASSERT_EQ(FindNearestTwo(query, candidates), BySorting(query, candidates)) << count;
    }
  }
}

TEST(DescriptorSearch, ByIndexReturnsThePositionOfTheIndex) {
  const auto descriptors = SimilarDescriptors(300, 2);
  std::vector<int> indices(300);
  std::iota(indices.begin(), indices.end(), 0);
  std::shuffle(indices.begin(), indices.end(), std::mt19937(3));
  for (const size_t count : {0, 3, 8, 29, 300}) {
    const std::span<const int> chosen(indices.data(), count);
    std::vector<Descriptor> copies;
    for (const int index : chosen) copies.push_back(descriptors[index]);
    for (const Descriptor& query : SimilarDescriptors(50, 4)) {
      ASSERT_EQ(FindNearestTwo(query, descriptors, chosen), BySorting(query, copies));
    }
  }
}

TEST(DescriptorSearch, ExtremeDistances) {
  Descriptor zeros;
  Descriptor ones;
  ones.words.fill(~uint64_t{0});
  EXPECT_EQ(FindNearestTwo(zeros, std::vector<Descriptor>(20, ones)), (NearestTwo{0, 256, 256}));
  std::vector<Descriptor> candidates(20, ones);
  candidates[13] = zeros;
  EXPECT_EQ(FindNearestTwo(zeros, candidates), (NearestTwo{13, 0, 256}));
}

}  // namespace
}  // namespace semmap
