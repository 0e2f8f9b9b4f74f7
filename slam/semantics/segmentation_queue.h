#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <thread>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "slam/common/mutex.h"
#include "slam/semantics/segmenter.h"

namespace semmap {

// One image on its way through a SegmentationQueue.
struct SegmentationJob;

// A segmentation that was asked for. Whoever drops it does not want it any more: an image that still waits is
// then left out.
class PendingSegmentation {
 public:
  PendingSegmentation() = default;
  explicit PendingSegmentation(std::shared_ptr<SegmentationJob> job) : job_(std::move(job)) {}
  ~PendingSegmentation();
  PendingSegmentation(PendingSegmentation&& other) noexcept = default;
  PendingSegmentation& operator=(PendingSegmentation&& other) noexcept;

  // Whether anything was asked for.
  explicit operator bool() const { return job_ != nullptr; }

  // Null when it is not there in time, was refused (the queue is full), or failed.
  std::shared_ptr<const Segmentation> Wait(absl::Duration timeout);

 private:
  void Drop();

  std::shared_ptr<SegmentationJob> job_;
};

// Lets many sessions share one segmenter: images that wait go through it as one batch. An image that finds
// the segmenter idle starts at once. Thread-safe.
class SegmentationQueue {
 public:
  struct Limits {
    int max_batch = 1;
    int max_waiting = 128;  // images; more are refused
  };

  // All grow.
  struct Counts {
    uint64_t submitted = 0;
    uint64_t segmented = 0;
    uint64_t refused = 0;    // the queue was full
    uint64_t abandoned = 0;  // nobody waited any more
    uint64_t failed = 0;
    uint64_t batches = 0;
  };

  SegmentationQueue(std::shared_ptr<Segmenter> segmenter, Limits limits);
  // What waits gets no answer.
  ~SegmentationQueue();
  SegmentationQueue(const SegmentationQueue&) = delete;
  SegmentationQueue& operator=(const SegmentationQueue&) = delete;

  // Never waits. The pixels are shared, not copied: they must not be overwritten as long as the image is held
  // here, which may be longer than somebody waits.
  PendingSegmentation Submit(const cv::Mat& image);

  Counts counts() const;

 private:
  using Batch = std::vector<std::shared_ptr<SegmentationJob>>;

  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return closing_ || !waiting_.empty(); }
  void Work();
  // Empty: the queue closes.
  Batch NextBatch();
  void Run(const Batch& batch);

  const std::shared_ptr<Segmenter> segmenter_;
  const Limits limits_;
  mutable Mutex mutex_;  // guards the queue
  std::deque<std::shared_ptr<SegmentationJob>> waiting_ ABSL_GUARDED_BY(mutex_);
  Counts counts_ ABSL_GUARDED_BY(mutex_);
  bool closing_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread worker_;
};

}  // namespace semmap
