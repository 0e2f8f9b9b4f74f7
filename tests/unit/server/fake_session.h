#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "server/vehicle_session.h"
#include "slam/common/mutex.h"
#include "slam/pipeline/session.h"

namespace semmap::server {

// Holds back or lets through the frames of fake sessions, and remembers which came. Thread-safe.
class FrameGate {
 public:
  void Close() {
    MutexLock lock(&mutex_);
    open_ = false;
  }
  void Open() {
    MutexLock lock(&mutex_);
    open_ = true;
  }
  // Of a session: enters a frame and waits until the gate is open.
  void Pass(uint64_t sequence) {
    MutexLock lock(&mutex_);
    seen_.push_back(sequence);
    mutex_.Await([this] { return open_; });
  }
  // Until `count` frames have come to the gate; false after ten seconds.
  bool WaitForFrames(size_t count) {
    const auto enough = [this, count] {
      mutex_.AssertHeld();
      return seen_.size() >= count;
    };
    MutexLock lock(&mutex_);
    return mutex_.AwaitWithTimeout(absl::Seconds(10), enough);
  }
  std::vector<uint64_t> seen() const {
    MutexLock lock(&mutex_);
    return seen_;
  }

 private:
  mutable Mutex mutex_;
  bool open_ = true;
  std::vector<uint64_t> seen_;
};

// Stands in for SLAM where a test is about the service: tracks every frame to x = sequence, and makes every
// fifth one a keyframe with one point, whose delta brings the frames since the last.
class FakeSession : public Session {
 public:
  static constexpr uint64_t kKeyFrameInterval = 5;

  FakeSession(MapDeltaSink* sink, FrameGate* gate) : sink_(sink), gate_(gate) {}

  static SlamSessionFactory Factory(FrameGate* gate) {
    return [gate](const SlamConfig&, const CameraRig& rig, MapDeltaSink* sink, Executor*,
                  SessionStart) -> absl::StatusOr<std::unique_ptr<Session>> {
      if (const absl::Status status = ValidateRig(rig); !status.ok()) return status;
      return std::make_unique<FakeSession>(sink, gate);
    };
  }

  absl::StatusOr<FrameResult> Track(const FrameInput& frame) override {
    if (gate_ != nullptr) gate_->Pass(frame.sequence);
    FrameResult result;
    result.sequence = frame.sequence;
    result.timestamp = frame.timestamp;
    result.state = TrackingState::kTracking;
    result.map_from_camera = PoseOf(frame.sequence);
    result.covariance = Matrix6d::Identity() * 1e-4;
    result.inliers = 100;
    result.is_keyframe = stats_.frames % kKeyFrameInterval == 0;
    if (result.is_keyframe) AddKeyFrame(frame);
    delta_.frames.push_back({frame.sequence, frame.timestamp, last_keyframe_, FromKeyFrame(frame.sequence)});
    if (result.is_keyframe) Deliver();
    ++stats_.frames;
    ++stats_.tracked_frames;
    result.map_version = version_;
    return result;
  }

  void WaitForMapper(int) override {}
  void Finish() override {
    if (!delta_.empty()) Deliver();
  }
  SessionStats Stats() const override { return stats_; }

 private:
  static SE3 PoseOf(uint64_t sequence) {
    return SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(static_cast<double>(sequence), 0, 0));
  }
  SE3 FromKeyFrame(uint64_t sequence) const { return PoseOf(last_sequence_).Inverse() * PoseOf(sequence); }

  void AddKeyFrame(const FrameInput& frame) {
    auto features = std::make_shared<FrameFeatures>();
    features->keypoints.resize(2);
    features->descriptors.resize(2);
    KeyFrameRecord keyframe;
    keyframe.id = KeyFrameId(static_cast<uint64_t>(++stats_.keyframes));
    keyframe.sequence = frame.sequence;
    keyframe.timestamp = frame.timestamp;
    keyframe.map_from_camera = PoseOf(frame.sequence);
    keyframe.parent = last_keyframe_;
    keyframe.features = features;
    last_keyframe_ = keyframe.id;
    last_sequence_ = frame.sequence;
    AddPoint(keyframe);
    delta_.added_keyframes.push_back(std::move(keyframe));
  }

  void AddPoint(const KeyFrameRecord& keyframe) {
    MapPointRecord point;
    point.id = MapPointId(static_cast<uint64_t>(++stats_.points));
    point.position_in_map = keyframe.map_from_camera.translation() + Eigen::Vector3d(0, 0, 10);
    point.normal = Eigen::Vector3f::UnitZ();
    point.min_distance = 1;
    point.max_distance = 100;
    point.reference_keyframe = keyframe.id;
    point.observation_count = 1;
    point.first_seen = keyframe.timestamp;
    point.last_seen = keyframe.timestamp;
    point.semantic_class = static_cast<uint8_t>(stats_.points % 2 == 0 ? 1 : 10);
    point.class_confidence = 1;
    point.votes = {{point.semantic_class, 1}};
    delta_.observations.push_back({keyframe.id, {point.id, MapPointId()}});
    delta_.upserted_points.push_back(std::move(point));
  }

  void Deliver() {
    delta_.version = ++version_;
    sink_->OnDelta(std::exchange(delta_, MapDelta()));
  }

  MapDeltaSink* const sink_;
  FrameGate* const gate_;
  MapDelta delta_;
  uint64_t version_ = 0;
  KeyFrameId last_keyframe_;
  uint64_t last_sequence_ = 0;
  SessionStats stats_;
};

}  // namespace semmap::server
