#include "server/shared_maps.h"

#include <gtest/gtest.h>

#include <thread>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

class SharedMapsTest : public ::testing::Test {
 protected:
  SharedMapsTest()
      : maps_([this](const storage::MapInfo&) -> absl::StatusOr<std::shared_ptr<ExtendedMap>> {
          ++loads_;
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
          if (!load_status_.ok()) return load_status_;
          return std::make_shared<ExtendedMap>(std::make_shared<SharedMap>());
        }) {
    first_.id = storage::MapId(1);
    second_.id = storage::MapId(2);
  }

  std::atomic<int> loads_ = 0;
  absl::Status load_status_;
  storage::MapInfo first_;
  storage::MapInfo second_;
  SharedMaps maps_;
};

TEST_F(SharedMapsTest, AMapIsLoadedOnceForAllWhoHoldIt) {
  const auto one = maps_.Get(first_);
  const auto two = maps_.Get(first_);
  ASSERT_TRUE(one.ok() && two.ok());
  EXPECT_EQ(*one, *two);
  EXPECT_EQ(loads_, 1);
  EXPECT_NE(*maps_.Get(second_), *one);
  EXPECT_EQ(loads_, 2);
}

TEST_F(SharedMapsTest, WhenNobodyHoldsItItIsLoadedAnew) {
  { const auto held = maps_.Get(first_); }
  ASSERT_TRUE(maps_.Get(first_).ok());
  EXPECT_EQ(loads_, 2);
}

TEST_F(SharedMapsTest, ManyWhoComeAtOnceShareOneLoad) {
  std::vector<std::shared_ptr<ExtendedMap>> got(4);
  std::vector<std::thread> callers;
  for (auto& slot : got) callers.emplace_back([&] { slot = *maps_.Get(first_); });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(loads_, 1);
  for (const auto& map : got) EXPECT_EQ(map, got.front());
}

TEST_F(SharedMapsTest, AFailedLoadIsTriedAgain) {
  load_status_ = absl::UnavailableError("locked");
  EXPECT_EQ(maps_.Get(first_).status().code(), absl::StatusCode::kUnavailable);
  load_status_ = absl::OkStatus();
  EXPECT_TRUE(maps_.Get(first_).ok());
}

TEST_F(SharedMapsTest, WhatIsNewNeedsNoLoad) {
  const auto fresh = std::make_shared<ExtendedMap>(std::make_shared<SharedMap>());
  maps_.Put(first_.id, fresh);
  EXPECT_EQ(*maps_.Get(first_), fresh);
  EXPECT_EQ(loads_, 0);
}

TEST_F(SharedMapsTest, NobodyJoinsAMapThatIsAheadOfItsStore) {
  auto held = maps_.Get(first_);
  ASSERT_TRUE(held.ok());
  (*held)->store_failed = true;
  EXPECT_EQ(ReasonOf(maps_.Get(first_).status()), v1::ERROR_REASON_MAP_IN_USE);
  held->reset();
  EXPECT_TRUE(maps_.Get(first_).ok());
}

}  // namespace
}  // namespace semmap::server
