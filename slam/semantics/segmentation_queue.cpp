#include "slam/semantics/segmentation_queue.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

namespace semmap {

struct SegmentationJob {
  explicit SegmentationJob(cv::Mat pixels) : image(std::move(pixels)) {}

  void Finish(std::shared_ptr<const Segmentation> segmentation) {
    MutexLock lock(&mutex);
    result = std::move(segmentation);
    done = true;
  }

  cv::Mat image;  // touched by the queue alone
  std::atomic<bool> wanted = true;
  Mutex mutex;  // guards the answer
  bool done ABSL_GUARDED_BY(mutex) = false;
  std::shared_ptr<const Segmentation> result ABSL_GUARDED_BY(mutex);
};

// --- what a session holds

PendingSegmentation::~PendingSegmentation() { Drop(); }

PendingSegmentation& PendingSegmentation::operator=(PendingSegmentation&& other) noexcept {
  if (this == &other) return *this;
  Drop();
  job_ = std::move(other.job_);
  return *this;
}

void PendingSegmentation::Drop() {
  if (job_ != nullptr) job_->wanted = false;
  job_.reset();
}

std::shared_ptr<const Segmentation> PendingSegmentation::Wait(absl::Duration timeout) {
  if (job_ == nullptr) return nullptr;
  const auto is_done = [job = job_.get()] {
    job->mutex.AssertHeld();
    return job->done;
  };
  MutexLock lock(&job_->mutex);
  return job_->mutex.AwaitWithTimeout(timeout, is_done) ? job_->result : nullptr;
}

// --- the queue

SegmentationQueue::SegmentationQueue(std::shared_ptr<Segmenter> segmenter, Limits limits)
    : segmenter_(std::move(segmenter)), limits_(limits), worker_([this] { Work(); }) {}

SegmentationQueue::~SegmentationQueue() {
  {
    MutexLock lock(&mutex_);
    closing_ = true;
  }
  worker_.join();
}

PendingSegmentation SegmentationQueue::Submit(const cv::Mat& image) {
  auto job = std::make_shared<SegmentationJob>(image);
  MutexLock lock(&mutex_);
  ++counts_.submitted;
  if (closing_ || static_cast<int>(waiting_.size()) >= limits_.max_waiting) {
    ++counts_.refused;
    job->Finish(nullptr);
  } else {
    waiting_.push_back(job);
  }
  return PendingSegmentation(std::move(job));
}

SegmentationQueue::Counts SegmentationQueue::counts() const {
  MutexLock lock(&mutex_);
  return counts_;
}

void SegmentationQueue::Work() {
  for (Batch batch = NextBatch(); !batch.empty(); batch = NextBatch()) Run(batch);
  MutexLock lock(&mutex_);
  for (const auto& job : waiting_) job->Finish(nullptr);
  waiting_.clear();
}

SegmentationQueue::Batch SegmentationQueue::NextBatch() {
  Batch batch;
  MutexLock lock(&mutex_);
  while (batch.empty()) {
    mutex_.Await(&SegmentationQueue::HasWork, this);
    if (closing_) return batch;
    while (!waiting_.empty() && static_cast<int>(batch.size()) < limits_.max_batch) {
      if (waiting_.front()->wanted) {
        batch.push_back(std::move(waiting_.front()));
      } else {
        ++counts_.abandoned;
      }
      waiting_.pop_front();
    }
  }
  return batch;
}

void SegmentationQueue::Run(const Batch& batch) {
  std::vector<cv::Mat> images;
  for (const auto& job : batch) images.push_back(std::move(job->image));
  absl::StatusOr<std::vector<Segmentation>> segmented = segmenter_->Segment(images);
  if (!segmented.ok())
    spdlog::warn("segmentation failed images={} {}", images.size(), segmented.status().ToString());
  {
    MutexLock lock(&mutex_);
    ++counts_.batches;
    (segmented.ok() ? counts_.segmented : counts_.failed) += batch.size();
  }
  for (size_t i = 0; i < batch.size(); ++i) {
    batch[i]->Finish(segmented.ok() ? std::make_shared<const Segmentation>(std::move((*segmented)[i]))
                                    : nullptr);
  }
}

}  // namespace semmap
