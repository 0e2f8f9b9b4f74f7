#include "server/map_writer.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "absl/time/time.h"
#include "slam/common/notification.h"

namespace semmap::server {
namespace {

TEST(MapWriter, RunsJobsInOrderAndFinishesThem) {
  std::vector<int> order;
  {
    MapWriter writer(4);
    for (int i = 0; i < 20; ++i) writer.Post([&order, i] { order.push_back(i); });
  }
  ASSERT_EQ(order.size(), 20U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(order[static_cast<size_t>(i)], i);
}

TEST(MapWriter, AFullQueueMakesItsCallerWait) {
  Notification started;
  Notification release;
  MapWriter writer(2);
  writer.Post([&] {
    started.Notify();
    release.WaitForNotification();
  });
  started.WaitForNotification();
  writer.Post([] {});
  writer.Post([] {});
  Notification posted;
  std::thread poster([&] {
    writer.Post([] {});
    posted.Notify();
  });
  EXPECT_FALSE(posted.WaitForNotificationWithTimeout(absl::Milliseconds(50)));
  EXPECT_EQ(writer.waiting(), 2U);
  release.Notify();
  EXPECT_TRUE(posted.WaitForNotificationWithTimeout(absl::Seconds(10)));
  poster.join();
}

}  // namespace
}  // namespace semmap::server
