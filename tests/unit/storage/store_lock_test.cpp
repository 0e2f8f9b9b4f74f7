#include "storage/sqlite/store_lock.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "storage_test_support.h"

namespace semmap::storage::sqlite {
namespace {

class StoreLockTest : public ::testing::Test {
 protected:
  TempDir directory_;
  const std::string database_ = directory_.File("maps.db");
};

TEST_F(StoreLockTest, TheFirstIsAloneAndTheSecondIsNot) {
  auto first = std::make_unique<StoreLock>(database_);
  EXPECT_TRUE(first->is_alone());
  first->Share();
  EXPECT_FALSE(StoreLock(database_).is_alone());
  first.reset();
  EXPECT_TRUE(StoreLock(database_).is_alone());
}

TEST_F(StoreLockTest, TheSecondWaitsUntilTheFirstShares) {
  const StoreLock first(database_);
  std::atomic<bool> second_shares = false;
  std::thread other([&] {
    const StoreLock second(database_);
    second.Share();
    second_shares = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(second_shares);
  first.Share();
  other.join();
  EXPECT_TRUE(second_shares);
}

TEST_F(StoreLockTest, WithoutAFileEverybodyIsAlone) {
  const StoreLock memory(":memory:");
  EXPECT_TRUE(memory.is_alone());
  memory.Share();
  const StoreLock nowhere(directory_.File("no/such/directory/maps.db"));
  EXPECT_TRUE(nowhere.is_alone());
  EXPECT_TRUE(StoreLock(directory_.File("no/such/directory/maps.db")).is_alone());
}

}  // namespace
}  // namespace semmap::storage::sqlite
