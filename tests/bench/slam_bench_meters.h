#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/features2d.hpp>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"
#include "slam/evaluation/trajectory_collector.h"
#include "slam/map/map_delta.h"

namespace semmap::bench {

double ProcessCpuSeconds();
double ThreadCpuSeconds();
double PeakRssMb();

// The yardstick for times of different machines: cv::ORB with 2,000 features on 8 levels of factor 1.2, on
// one thread. Measures an even sample of the images, at most kMaxSamples or so of them.
class UnitTimer {
 public:
  explicit UnitTimer(std::optional<size_t> frame_count);

  void Offer(const cv::Mat& image);
  const std::vector<double>& milliseconds() const { return milliseconds_; }
  // The same in CPU time, which other programs on the machine disturb less.
  const std::vector<double>& cpu_milliseconds() const { return cpu_milliseconds_; }
  // What measuring itself has cost.
  double cpu_seconds() const { return cpu_seconds_; }

 private:
  cv::Ptr<cv::ORB> orb_;
  size_t interval_;
  size_t offered_ = 0;
  std::vector<double> milliseconds_;
  std::vector<double> cpu_milliseconds_;
  double cpu_seconds_ = 0;
};

// Hands the deltas to the trajectory collector and keeps count of what the map's records weigh. Thread-safe.
class MeasuringSink : public MapDeltaSink {
 public:
  void OnDelta(MapDelta delta) override;

  const TrajectoryCollector& collector() const { return collector_; }
  double BytesPerKeyFrame() const;
  double BytesPerPoint() const;

 private:
  void ApplyKeyFrames(const MapDelta& delta) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ApplyPoints(const MapDelta& delta) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  TrajectoryCollector collector_;
  mutable Mutex mutex_;
  std::unordered_map<KeyFrameId, size_t, IdHash> keyframe_bytes_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<MapPointId, size_t, IdHash> point_bytes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::bench
