#include "slam/common/mutex.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "slam/common/notification.h"

namespace semmap {
namespace {

struct Counter {
  bool IsAtLeastOne() const { return value >= 1; }

  Mutex mutex;
  int value = 0;
};

TEST(MutexTest, KeepsThreadsApart) {
  Counter counter;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&counter] {
      for (int j = 0; j < 10000; ++j) {
        MutexLock lock(&counter.mutex);
        ++counter.value;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(counter.value, 40000);
}

TEST(MutexTest, AwaitReturnsAtOnceWhenTheConditionHolds) {
  Counter counter;
  counter.value = 1;
  MutexLock lock(&counter.mutex);
  counter.mutex.Await(&Counter::IsAtLeastOne, &counter);
  EXPECT_TRUE(counter.mutex.AwaitWithTimeout(absl::ZeroDuration(), &Counter::IsAtLeastOne, &counter));
  EXPECT_TRUE(counter.mutex.AwaitWithDeadline(absl::InfinitePast(), &Counter::IsAtLeastOne, &counter));
}

TEST(MutexTest, AwaitWakesOnRelease) {
  Counter counter;
  std::thread other([&counter] {
    MutexLock lock(&counter.mutex);
    counter.value = 1;
  });
  {
    MutexLock lock(&counter.mutex);
    counter.mutex.Await(&Counter::IsAtLeastOne, &counter);
    EXPECT_EQ(counter.value, 1);
  }
  other.join();
}

// Two threads take turns, so each waits for what the other changes before it waits itself: with a waiter that
// does not wake others when it begins to wait, this hangs.
TEST(MutexTest, BeginningToWaitLetsOthersLookAgain) {
  constexpr int kTurns = 1000;
  Counter turn;
  std::thread other([&turn] {
    MutexLock lock(&turn.mutex);
    for (int i = 1; i < kTurns; i += 2) {
      turn.mutex.Await([&turn, i] { return turn.value == i; });
      ++turn.value;
    }
  });
  {
    MutexLock lock(&turn.mutex);
    for (int i = 0; i < kTurns; i += 2) {
      turn.mutex.Await([&turn, i] { return turn.value == i; });
      ++turn.value;
    }
  }
  other.join();
  EXPECT_EQ(turn.value, kTurns);
}

TEST(MutexTest, TimeoutPassesAndTheMutexIsHeldAfterwards) {
  Counter counter;
  MutexLock lock(&counter.mutex);
  const absl::Time begin = absl::Now();
  EXPECT_FALSE(counter.mutex.AwaitWithTimeout(absl::Milliseconds(30), &Counter::IsAtLeastOne, &counter));
  EXPECT_GE(absl::Now() - begin, absl::Milliseconds(25));
  EXPECT_FALSE(counter.mutex.AwaitWithTimeout(-absl::InfiniteDuration(), &Counter::IsAtLeastOne, &counter));

  std::atomic<bool> entered = false;
  std::thread other([&] {
    MutexLock other_lock(&counter.mutex);
    entered = true;
    counter.value = 1;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(entered);
  EXPECT_TRUE(counter.mutex.AwaitWithTimeout(absl::InfiniteDuration(), &Counter::IsAtLeastOne, &counter));
  other.join();
}

// Whoever waited for the last holder may destroy the mutex; the sanitizers watch.
TEST(MutexTest, MayBeDestroyedByTheOneWhoWaited) {
  for (int i = 0; i < 200; ++i) {
    auto counter = std::make_unique<Counter>();
    std::thread other([shared = counter.get()] {
      MutexLock lock(&shared->mutex);
      shared->value = 1;
    });
    {
      MutexLock lock(&counter->mutex);
      counter->mutex.Await(&Counter::IsAtLeastOne, counter.get());
    }
    counter.reset();
    other.join();
  }
}

TEST(NotificationTest, TellsOnceAndForAll) {
  Notification event;
  EXPECT_FALSE(event.HasBeenNotified());
  EXPECT_FALSE(event.WaitForNotificationWithTimeout(absl::Milliseconds(1)));
  std::thread other([&event] { event.Notify(); });
  event.WaitForNotification();
  EXPECT_TRUE(event.HasBeenNotified());
  EXPECT_TRUE(event.WaitForNotificationWithTimeout(absl::ZeroDuration()));
  other.join();
}

}  // namespace
}  // namespace semmap
