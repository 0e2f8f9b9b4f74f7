#pragma once

#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "slam/common/mutex.h"
#include "slam/semantics/segmenter.h"

namespace semmap {

// Gives every pixel of an image the class that its first pixel's blue (or grey) value names. Can be held
// back, and remembers the sizes of its batches. Thread-safe.
class FakeSegmenter : public Segmenter {
 public:
  absl::StatusOr<std::vector<Segmentation>> Segment(std::span<const cv::Mat> images) override {
    {
      MutexLock lock(&mutex_);
      batches_.push_back(images.size());
      mutex_.Await([this] { return open_; });
      if (!status_.ok()) return status_;
    }
    std::vector<Segmentation> segmentations;
    for (const cv::Mat& image : images) segmentations.push_back(All(image.size(), image.data[0]));
    return segmentations;
  }

  void Close() { Set(&open_, false); }
  void Open() { Set(&open_, true); }
  void FailWith(absl::Status status) { Set(&status_, std::move(status)); }

  // Sizes of the batches that began; waits up to ten seconds for `count` of them.
  std::vector<size_t> WaitForBatches(size_t count) {
    MutexLock lock(&mutex_);
    mutex_.AwaitWithTimeout(absl::Seconds(10), [this, count] { return batches_.size() >= count; });
    return batches_;
  }

 private:
  static Segmentation All(cv::Size image, uint8_t semantic_class) {
    // The other class is as good as impossible.
    return {
        image,
        {1, 1},
        {0.0F, -50.0F},
        std::make_shared<const std::vector<uint8_t>>(std::vector<uint8_t>{semantic_class, kUnknownClass})};
  }
  template <typename T>
  void Set(T* field, T value) {
    MutexLock lock(&mutex_);
    *field = std::move(value);
  }

  Mutex mutex_;
  bool open_ = true;
  absl::Status status_;
  std::vector<size_t> batches_;
};

}  // namespace semmap
