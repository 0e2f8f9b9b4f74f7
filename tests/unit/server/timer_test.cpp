#include "server/timer.h"

#include <vector>

#include <gtest/gtest.h>

#include "slam/common/notification.h"

namespace semmap::server {
namespace {

TEST(Timer, CallsInTheOrderOfTime) {
  std::vector<int> order;
  Notification done;
  Timer timer;
  timer.After(absl::Milliseconds(60), [&] {
    order.push_back(2);
    done.Notify();
  });
  timer.After(absl::Milliseconds(10), [&] { order.push_back(1); });
  ASSERT_TRUE(done.WaitForNotificationWithTimeout(absl::Seconds(10)));
  EXPECT_EQ(order, (std::vector<int>{1, 2}));
}

TEST(Timer, DropsWhatIsNotDueWhenItGoes) {
  bool called = false;
  {
    Timer().After(absl::Hours(1), [&] { called = true; });
  }
  EXPECT_FALSE(called);
}

}  // namespace
}  // namespace semmap::server
