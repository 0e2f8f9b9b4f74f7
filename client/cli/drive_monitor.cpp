#include "client/cli/drive_monitor.h"

#include "client/cli/rig_conversion.h"

namespace semmap::client {
namespace {

const char* NameOf(v1::TrackingState state) {
  switch (state) {
    case v1::TRACKING_STATE_INITIALIZING:
      return "initializing";
    case v1::TRACKING_STATE_TRACKING:
      return "tracking";
    case v1::TRACKING_STATE_LOST:
      return "lost";
    default:
      return "unknown";
  }
}

}  // namespace

DriveObserver DriveMonitor::Observer() {
  DriveObserver observer;
  observer.on_estimate = [this](const v1::FrameEstimate& estimate) { OnEstimate(estimate); };
  observer.on_dropped = [this](const v1::FramesDropped& dropped) { OnDropped(dropped); };
  return observer;
}

void DriveMonitor::NoteSent(uint64_t sequence) {
  const MutexLock lock(&mutex_);
  const auto now = Clock::now();
  if (!first_sent_) first_sent_ = now;
  in_flight_[sequence] = now;
  ++progress_.sent;
}

void DriveMonitor::OnEstimate(const v1::FrameEstimate& estimate) {
  const MutexLock lock(&mutex_);
  const auto now = Clock::now();
  const auto sent = in_flight_.find(estimate.sequence());
  // After a resume the server may repeat an answer.
  if (sent == in_flight_.end()) return;
  progress_.latency_ms = std::chrono::duration<double, std::milli>(now - sent->second).count();
  in_flight_.erase(sent);
  latencies_.answer_ms.push_back(progress_.latency_ms);
  latencies_.track_ms.push_back(estimate.times().track_ms());
  ++progress_.answered;
  const double elapsed_s = std::chrono::duration<double>(now - *first_sent_).count();
  if (elapsed_s > 0) progress_.frames_per_second = static_cast<double>(progress_.answered) / elapsed_s;
  progress_.tracking = NameOf(estimate.state());
  if (estimate.keyframe()) ++progress_.keyframes;
  // In the frame of its own piece a vehicle does not say where in the map it is.
  if (estimate.has_map_from_camera() && estimate.reference_frame() != v1::REFERENCE_FRAME_SESSION) {
    online_poses_[estimate.sequence()] = {estimate.timestamp_ns(), FromProto(estimate.map_from_camera())};
  }
}

void DriveMonitor::OnDropped(const v1::FramesDropped& dropped) {
  const MutexLock lock(&mutex_);
  for (const uint64_t sequence : dropped.sequences()) progress_.answered += in_flight_.erase(sequence);
}

DriveProgress DriveMonitor::Progress() const {
  const MutexLock lock(&mutex_);
  return progress_;
}

DriveMonitor::Latencies DriveMonitor::latencies() const {
  const MutexLock lock(&mutex_);
  return latencies_;
}

SequencedPoses DriveMonitor::online_poses() const {
  const MutexLock lock(&mutex_);
  return online_poses_;
}

}  // namespace semmap::client
