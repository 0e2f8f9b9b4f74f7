#include "slam/pipeline/map_part_cache.h"

#include <random>
#include <thread>

#include <gtest/gtest.h>

namespace semmap {
namespace {

constexpr uint64_t kMap = 3;
constexpr uint64_t kVersion = 7;

std::shared_ptr<const PointBlock> BlockOf(uint64_t first, size_t points) {
  auto block = std::make_shared<PointBlock>();
  for (uint64_t i = 0; i < points; ++i) {
    ViewPoint point;
    point.id = MapPointId(first + i);
    point.observation_count = static_cast<uint32_t>(first + i);
    block->Add(point, i % 2 == 0);
  }
  return block;
}

std::shared_ptr<const KeyFramePart> KeyFrameOf(size_t keypoints) {
  auto features = std::make_shared<FrameFeatures>();
  features->keypoints.resize(keypoints);
  features->descriptors.resize(keypoints);
  auto part = std::make_shared<KeyFramePart>();
  part->features = std::move(features);
  part->points.resize(keypoints);
  return part;
}

TEST(PointBlockTest, FindsActivePointsById) {
  auto block = std::make_shared<PointBlock>();
  for (const uint64_t id : {128, 130, 191}) {
    ViewPoint point;
    point.id = MapPointId(id);
    block->Add(point, id != 130);
  }
  EXPECT_EQ(PointBlock::NumberOf(MapPointId(191)), PointBlock::NumberOf(MapPointId(128)));
  EXPECT_NE(PointBlock::NumberOf(MapPointId(192)), PointBlock::NumberOf(MapPointId(128)));
  EXPECT_EQ(block->FindActive(MapPointId(128))->id, MapPointId(128));
  EXPECT_EQ(block->FindActive(MapPointId(191))->id, MapPointId(191));
  EXPECT_EQ(block->FindActive(MapPointId(130)), nullptr) << "inactive";
  EXPECT_EQ(block->FindActive(MapPointId(129)), nullptr) << "not there";
}

TEST(MapPartCacheTest, KeepsKindsMapsAndVersionsApart) {
  MapPartCache cache(size_t{1} << 20);
  cache.Put(kMap, KeyFrameId(1), kVersion, KeyFrameOf(3));
  cache.Put(kMap, KeyFrameId(1), kVersion, std::make_shared<const DirectIndex>());
  cache.Put(kMap, 1, kVersion, BlockOf(64, 2));
  EXPECT_EQ(cache.FindKeyFrame(kMap, KeyFrameId(1), kVersion)->points.size(), 3U);
  EXPECT_NE(cache.FindNodes(kMap, KeyFrameId(1), kVersion), nullptr);
  EXPECT_NE(cache.FindPoints(kMap, 1, kVersion), nullptr);
  EXPECT_EQ(cache.FindKeyFrame(kMap + 1, KeyFrameId(1), kVersion), nullptr);
  EXPECT_EQ(cache.FindKeyFrame(kMap, KeyFrameId(1), kVersion + 1), nullptr);
  EXPECT_EQ(cache.FindPoints(kMap, 2, kVersion), nullptr);
  cache.Put(kMap, KeyFrameId(1), kVersion + 1, KeyFrameOf(5));
  EXPECT_EQ(cache.FindKeyFrame(kMap, KeyFrameId(1), kVersion), nullptr) << "replaced";
  EXPECT_EQ(cache.FindKeyFrame(kMap, KeyFrameId(1), kVersion + 1)->points.size(), 5U);
}

TEST(MapPartCacheTest, WhatWasNotAskedForLongestGoes) {
  const size_t bytes = KeyFrameOf(100)->MemoryBytes();
  MapPartCache cache(3 * bytes + 3 * 256);
  for (uint64_t id = 1; id <= 3; ++id) cache.Put(kMap, KeyFrameId(id), kVersion, KeyFrameOf(100));
  const auto held = cache.FindKeyFrame(kMap, KeyFrameId(2), kVersion);
  ASSERT_NE(cache.FindKeyFrame(kMap, KeyFrameId(1), kVersion), nullptr);
  cache.Put(kMap, KeyFrameId(4), kVersion, KeyFrameOf(100));
  EXPECT_EQ(cache.FindKeyFrame(kMap, KeyFrameId(3), kVersion), nullptr);
  cache.Put(kMap, KeyFrameId(5), kVersion, KeyFrameOf(100));
  EXPECT_EQ(cache.FindKeyFrame(kMap, KeyFrameId(2), kVersion), nullptr);
  EXPECT_EQ(held->points.size(), 100U) << "stays with who holds it";
  EXPECT_NE(cache.FindKeyFrame(kMap, KeyFrameId(1), kVersion), nullptr);
  EXPECT_NE(cache.FindKeyFrame(kMap, KeyFrameId(5), kVersion), nullptr);
}

TEST(MapPartCacheTest, CountsItsBytesAndKeepsToTheLimit) {
  MapPartCache cache(100'000);
  EXPECT_EQ(cache.memory_bytes(), 0U);
  cache.Put(kMap, 1, kVersion, BlockOf(64, 64));
  const size_t one = cache.memory_bytes();
  EXPECT_GE(one, BlockOf(64, 64)->MemoryBytes());
  cache.Put(kMap, 1, kVersion, BlockOf(64, 64));
  EXPECT_EQ(cache.memory_bytes(), one) << "replaced";
  for (uint64_t block = 2; block < 100; ++block) cache.Put(kMap, block, kVersion, BlockOf(64 * block, 64));
  EXPECT_LE(cache.memory_bytes(), 100'000U);
  EXPECT_GT(cache.memory_bytes(), 100'000U - one);
  cache.SetMaxBytes(2 * one);
  EXPECT_EQ(cache.memory_bytes(), 2 * one);
  cache.Put(kMap, KeyFrameId(1), kVersion, KeyFrameOf(10'000));
  EXPECT_EQ(cache.memory_bytes(), 0U) << "what does not fit alone is not kept";
}

// Readers and writers at once get what was put under the key, or nothing.
TEST(MapPartCacheTest, ServesManyThreads) {
  MapPartCache cache(40'000);
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t) {
    threads.emplace_back([&cache, t] {
      std::mt19937 random(t);
      for (int i = 0; i < 3000; ++i) {
        const uint64_t number = random() % 40;
        const uint64_t version = random() % 2;
        const auto block = cache.FindPoints(kMap, number, version);
        if (block == nullptr) {
          cache.Put(kMap, number, version, BlockOf(64 * number, 1 + version));
          continue;
        }
        const ViewPoint* first = block->FindActive(MapPointId(64 * number));
        ASSERT_NE(first, nullptr);
        EXPECT_EQ(first->observation_count, 64 * number);
        if (i % 500 == 0) cache.SetMaxBytes(20'000 + random() % 20'000);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(cache.memory_bytes(), 40'000U);
}

}  // namespace
}  // namespace semmap
