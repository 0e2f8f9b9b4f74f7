#include "server/frame_queue.h"

#include <gtest/gtest.h>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

v1::Frame Frame(uint64_t sequence, int64_t timestamp_ns) {
  v1::Frame frame;
  frame.set_sequence(sequence);
  frame.set_timestamp_ns(timestamp_ns);
  return frame;
}
v1::Frame Frame(uint64_t sequence) { return Frame(sequence, static_cast<int64_t>(sequence) * 100); }

absl::Status Push(FrameQueue& queue, v1::Frame frame) { return queue.Push(std::move(frame), absl::Time()); }

TEST(FrameQueue, KeepsOrderAndAllowsGaps) {
  FrameQueue queue(4, v1::OVERLOAD_POLICY_BLOCK);
  ASSERT_TRUE(Push(queue, Frame(3)).ok());
  ASSERT_TRUE(Push(queue, Frame(7)).ok());
  EXPECT_EQ(queue.Pop()->frame.sequence(), 3U);
  EXPECT_EQ(queue.Pop()->frame.sequence(), 7U);
  EXPECT_FALSE(queue.Pop().has_value());
}

TEST(FrameQueue, RefusesWhatRunsBackwards) {
  FrameQueue queue(4, v1::OVERLOAD_POLICY_BLOCK);
  EXPECT_EQ(ReasonOf(Push(queue, Frame(0, 5))), v1::ERROR_REASON_SEQUENCE_NOT_INCREASING);
  ASSERT_TRUE(Push(queue, Frame(2, -50)).ok());
  EXPECT_EQ(ReasonOf(Push(queue, Frame(2, 300))), v1::ERROR_REASON_SEQUENCE_NOT_INCREASING);
  EXPECT_EQ(ReasonOf(Push(queue, Frame(1, 300))), v1::ERROR_REASON_SEQUENCE_NOT_INCREASING);
  EXPECT_EQ(ReasonOf(Push(queue, Frame(3, -50))), v1::ERROR_REASON_TIME_NOT_INCREASING);
  EXPECT_EQ(ReasonOf(Push(queue, Frame(3, -51))), v1::ERROR_REASON_TIME_NOT_INCREASING);
  ASSERT_TRUE(Push(queue, Frame(3, -49)).ok());
  EXPECT_EQ(queue.received(), 2U);
}

TEST(FrameQueue, BlockReturnsCreditWhenAFrameIsProcessed) {
  FrameQueue queue(2, v1::OVERLOAD_POLICY_BLOCK);
  ASSERT_TRUE(Push(queue, Frame(1)).ok());
  ASSERT_TRUE(Push(queue, Frame(2)).ok());
  EXPECT_EQ(ReasonOf(Push(queue, Frame(3))), v1::ERROR_REASON_CREDIT_EXCEEDED);
  queue.Pop();
  EXPECT_EQ(queue.TakeReturnedCredit(), 0);
  queue.OnProcessed();
  // It is the vehicle's only once it was handed over.
  EXPECT_EQ(ReasonOf(Push(queue, Frame(3))), v1::ERROR_REASON_CREDIT_EXCEEDED);
  EXPECT_EQ(queue.TakeReturnedCredit(), 1);
  EXPECT_TRUE(Push(queue, Frame(3)).ok());
}

TEST(FrameQueue, LatestWinsDropsWhatWaitsAndCounts) {
  FrameQueue queue(2, v1::OVERLOAD_POLICY_LATEST_WINS);
  ASSERT_TRUE(Push(queue, Frame(1)).ok());
  EXPECT_EQ(queue.Pop()->frame.sequence(), 1U);
  for (uint64_t sequence = 2; sequence <= 5; ++sequence) {
    EXPECT_EQ(queue.TakeReturnedCredit(), 1);
    ASSERT_TRUE(Push(queue, Frame(sequence)).ok());
  }
  EXPECT_EQ(queue.dropped(), 3U);
  const auto latest = queue.Pop();
  ASSERT_TRUE(latest.has_value());
  EXPECT_EQ(latest->frame.sequence(), 5U);
  EXPECT_EQ(latest->dropped, (std::vector<uint64_t>{2, 3, 4}));
  EXPECT_TRUE(queue.empty());
}

TEST(FrameQueue, AfterARestartOldFramesArePassedOver) {
  FrameQueue queue(3, v1::OVERLOAD_POLICY_BLOCK);
  ASSERT_TRUE(Push(queue, Frame(1)).ok());
  ASSERT_TRUE(Push(queue, Frame(2)).ok());
  queue.Pop();
  EXPECT_EQ(queue.Restart(), 1);  // one in the tracker, one waiting
  ASSERT_TRUE(Push(queue, Frame(2)).ok());
  EXPECT_EQ(queue.received(), 2U);
  EXPECT_EQ(queue.TakeReturnedCredit(), 1);
  ASSERT_TRUE(Push(queue, Frame(3)).ok());
  EXPECT_EQ(queue.received(), 3U);
}

}  // namespace
}  // namespace semmap::server
