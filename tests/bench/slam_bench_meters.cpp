#include "tests/bench/slam_bench_meters.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include <opencv2/core/utility.hpp>

namespace semmap::bench {
namespace {

constexpr int kUnitFeatures = 2000;
constexpr float kUnitScale = 1.2F;
constexpr int kUnitLevels = 8;
constexpr size_t kMaxSamples = 50;

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

size_t BytesOf(const KeyFrameRecord& keyframe) {
  constexpr size_t kPerKeypoint = sizeof(Keypoint) + sizeof(Descriptor) + sizeof(MapPointId);
  return sizeof(KeyFrameRecord) + keyframe.features->size() * kPerKeypoint;
}

size_t BytesOf(const MapPointRecord& point) {
  return sizeof(MapPointRecord) + point.votes.size() * sizeof(ClassVote);
}

template <typename Map>
double MeanValue(const Map& map) {
  if (map.empty()) return 0;
  double sum = 0;
  for (const auto& entry : map) sum += static_cast<double>(entry.second);
  return sum / static_cast<double>(map.size());
}

}  // namespace

double ProcessCpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
}

double ThreadCpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double PeakRssMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

UnitTimer::UnitTimer(std::optional<size_t> frame_count)
    : orb_(cv::ORB::create(kUnitFeatures, kUnitScale, kUnitLevels)),
      interval_(std::max<size_t>(1, frame_count.value_or(kMaxSamples * 10) / kMaxSamples)) {}

void UnitTimer::Offer(const cv::Mat& image) {
  if (offered_++ % interval_ != 0) return;
  const double cpu_before = ThreadCpuSeconds();
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  const auto start = std::chrono::steady_clock::now();
  orb_->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  cv::setNumThreads(threads);
  milliseconds_.push_back(took.count());
  const double cpu_s = ThreadCpuSeconds() - cpu_before;
  cpu_milliseconds_.push_back(1e3 * cpu_s);
  cpu_seconds_ += cpu_s;
}

void MeasuringSink::OnDelta(MapDelta delta) {
  {
    const MutexLock lock(&mutex_);
    if (delta.reset) {
      keyframe_bytes_.clear();
      point_bytes_.clear();
    }
    ApplyKeyFrames(delta);
    ApplyPoints(delta);
  }
  collector_.OnDelta(std::move(delta));
}

void MeasuringSink::ApplyKeyFrames(const MapDelta& delta) {
  for (const KeyFrameRecord& keyframe : delta.added_keyframes)
    keyframe_bytes_[keyframe.id] = BytesOf(keyframe);
  for (const RemovedKeyFrame& removed : delta.removed_keyframes) keyframe_bytes_.erase(removed.removed);
}

void MeasuringSink::ApplyPoints(const MapDelta& delta) {
  for (const MapPointRecord& point : delta.upserted_points) point_bytes_[point.id] = BytesOf(point);
  for (const MapPointId id : delta.removed_points) point_bytes_.erase(id);
}

double MeasuringSink::BytesPerKeyFrame() const {
  const MutexLock lock(&mutex_);
  return MeanValue(keyframe_bytes_);
}

double MeasuringSink::BytesPerPoint() const {
  const MutexLock lock(&mutex_);
  return MeanValue(point_bytes_);
}

}  // namespace semmap::bench
