#include "slam/semantics/segmentation_queue.h"

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "tests/support/fake_segmenter.h"

namespace semmap {
namespace {

constexpr absl::Duration kLong = absl::Seconds(10);

cv::Mat ImageOf(uint8_t semantic_class) { return {4, 6, CV_8UC1, cv::Scalar(semantic_class)}; }

// Zero when there is no answer in time.
int ClassOf(PendingSegmentation pending, absl::Duration timeout = kLong) {
  const auto segmentation = pending.Wait(timeout);
  return segmentation == nullptr ? 0 : segmentation->At(0, 0).semantic_class;
}

class SegmentationQueueTest : public testing::Test {
 protected:
  // Occupies the segmenter, so that what comes next waits.
  PendingSegmentation Occupy(SegmentationQueue* queue) {
    segmenter_->Close();
    PendingSegmentation first = queue->Submit(ImageOf(1));
    EXPECT_EQ(segmenter_->WaitForBatches(1).size(), 1U);
    return first;
  }

  std::shared_ptr<FakeSegmenter> segmenter_ = std::make_shared<FakeSegmenter>();
};

TEST_F(SegmentationQueueTest, AnswersBelongToTheirImages) {
  SegmentationQueue queue(segmenter_, {});
  std::vector<PendingSegmentation> pending;
  for (uint8_t id = 1; id <= 20; ++id) pending.push_back(queue.Submit(ImageOf(id)));
  for (uint8_t id = 1; id <= 20; ++id) EXPECT_EQ(ClassOf(std::move(pending[id - 1])), id);
  EXPECT_EQ(queue.counts().segmented, 20U);
}

TEST_F(SegmentationQueueTest, WhatWaitsGoesThroughInBatches) {
  SegmentationQueue queue(segmenter_, {.max_batch = 3, .max_waiting = 100});
  std::vector<PendingSegmentation> pending;
  pending.push_back(Occupy(&queue));
  for (uint8_t id = 2; id <= 6; ++id) pending.push_back(queue.Submit(ImageOf(id)));
  segmenter_->Open();
  EXPECT_EQ(segmenter_->WaitForBatches(3), (std::vector<size_t>{1, 3, 2}));
  for (uint8_t id = 1; id <= 6; ++id) EXPECT_EQ(ClassOf(std::move(pending[id - 1])), id);
  EXPECT_EQ(queue.counts().batches, 3U);
}

TEST_F(SegmentationQueueTest, AFullQueueRefusesAtOnce) {
  SegmentationQueue queue(segmenter_, {.max_batch = 3, .max_waiting = 2});
  PendingSegmentation first = Occupy(&queue);
  PendingSegmentation second = queue.Submit(ImageOf(2));
  PendingSegmentation third = queue.Submit(ImageOf(3));
  EXPECT_EQ(ClassOf(queue.Submit(ImageOf(4)), absl::InfiniteDuration()), 0);
  EXPECT_EQ(queue.counts().refused, 1U);
  segmenter_->Open();
  EXPECT_EQ(ClassOf(std::move(third)), 3);
}

TEST_F(SegmentationQueueTest, NobodyWaitsLongerThanHeWants) {
  SegmentationQueue queue(segmenter_, {});
  PendingSegmentation first = Occupy(&queue);
  const absl::Time start = absl::Now();
  EXPECT_EQ(first.Wait(absl::Milliseconds(20)), nullptr);
  EXPECT_GE(absl::Now() - start, absl::Milliseconds(19));
  segmenter_->Open();
  EXPECT_EQ(ClassOf(std::move(first)), 1);
}

TEST_F(SegmentationQueueTest, WhatIsNotWantedAnyMoreIsLeftOut) {
  SegmentationQueue queue(segmenter_, {});
  PendingSegmentation first = Occupy(&queue);
  { const PendingSegmentation dropped = queue.Submit(ImageOf(2)); }
  PendingSegmentation replaced = queue.Submit(ImageOf(3));
  replaced = queue.Submit(ImageOf(4));
  segmenter_->Open();
  EXPECT_EQ(ClassOf(std::move(replaced)), 4);
  EXPECT_EQ(segmenter_->WaitForBatches(2), (std::vector<size_t>{1, 1}));
  EXPECT_EQ(queue.counts().abandoned, 2U);
  EXPECT_EQ(queue.counts().segmented, 2U);
}

TEST_F(SegmentationQueueTest, AFailureIsNoAnswer) {
  SegmentationQueue queue(segmenter_, {});
  segmenter_->FailWith(absl::InternalError("the scores are not numbers"));
  EXPECT_EQ(ClassOf(queue.Submit(ImageOf(2)), absl::InfiniteDuration()), 0);
  segmenter_->FailWith(absl::OkStatus());
  EXPECT_EQ(ClassOf(queue.Submit(ImageOf(3))), 3);
  EXPECT_EQ(queue.counts().failed, 1U);
}

TEST_F(SegmentationQueueTest, ClosingAnswersEverybody) {
  auto queue = std::make_unique<SegmentationQueue>(segmenter_, SegmentationQueue::Limits{.max_batch = 1});
  PendingSegmentation first = Occupy(queue.get());
  PendingSegmentation second = queue->Submit(ImageOf(2));
  std::thread closing([&queue] { queue.reset(); });
  absl::SleepFor(absl::Milliseconds(20));
  segmenter_->Open();
  closing.join();
  EXPECT_EQ(ClassOf(std::move(first), absl::ZeroDuration()), 1);
  EXPECT_EQ(second.Wait(absl::InfiniteDuration()), nullptr);
}

TEST_F(SegmentationQueueTest, ManyThreadsShareIt) {
  SegmentationQueue queue(segmenter_, {});
  std::vector<std::thread> sessions;
  for (int thread = 0; thread < 4; ++thread) {
    sessions.emplace_back([&queue, thread] {
      for (int i = 0; i < 200; ++i) {
        const auto id = static_cast<uint8_t>(1 + (thread * 50 + i) % 200);
        EXPECT_EQ(ClassOf(queue.Submit(ImageOf(id))), id);
      }
    });
  }
  for (std::thread& session : sessions) session.join();
  EXPECT_EQ(queue.counts().segmented, 800U);
}

}  // namespace
}  // namespace semmap
