#include "vehicle.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include "absl/time/clock.h"
#include "client/drive.h"
#include "connect.h"
#include "slam/common/status_macros.h"

namespace semmap::kill_test {

std::vector<uint64_t> Testimony::Durable(const std::vector<uint64_t>& sequences) const {
  std::vector<uint64_t> durable;
  std::copy_if(sequences.begin(), sequences.end(), std::back_inserter(durable),
               [this](uint64_t sequence) { return sequence <= acknowledged; });
  return durable;
}

Vehicle::Vehicle(const Recording& recording, const std::string& address, const std::string& map,
                 v1::SessionMode mode) {
  told_.recording = &recording;
  told_.map = map;
  told_.mode = mode;
  thread_ = std::thread([this, address] { Run(address); });
}

Vehicle::~Vehicle() {
  if (thread_.joinable()) thread_.join();
}

void Vehicle::Run(const std::string& address) {
  absl::Status end = Drive(address);
  MutexLock lock(&mutex_);
  told_.end = std::move(end);
  over_ = true;
}

absl::Status Vehicle::Drive(const std::string& address) {
  const Recording& recording = *[this] {
    MutexLock lock(&mutex_);
    return told_.recording;
  }();
  client::DriveObserver observer;
  observer.on_estimate = [this](const v1::FrameEstimate& estimate) {
    MutexLock lock(&mutex_);
    told_.answers.push_back(absl::Now());
    if (estimate.state() == v1::TRACKING_STATE_TRACKING) told_.tracked.push_back(estimate.sequence());
    if (estimate.keyframe()) told_.keyframes.push_back(estimate.sequence());
  };
  observer.on_acknowledgement = [this](const v1::Acknowledgement& acknowledgement) {
    MutexLock lock(&mutex_);
    told_.acknowledged = std::max(told_.acknowledged, acknowledgement.sequence());
  };
  observer.on_correction = [this](const v1::MapCorrection& /*correction*/) {
    MutexLock lock(&mutex_);
    if (!told_.corrected) told_.corrected = absl::Now();
  };
  client::DriveOptions options;
  options.vehicle_id = "car";
  options.rig = recording.rig;
  options.resume = false;
  {
    MutexLock lock(&mutex_);
    options.mode = told_.mode;
    options.map = told_.map;
  }
  SEMMAP_ASSIGN_OR_RETURN(const auto connection, Connect(address));
  SEMMAP_ASSIGN_OR_RETURN(const auto drive, client::Drive::Start(connection, options, observer));
  {
    MutexLock lock(&mutex_);
    told_.session = drive->started().session();
    told_.resume_token = drive->started().resume_token();
  }
  for (const v1::Frame& frame : recording.frames) SEMMAP_RETURN_IF_ERROR(drive->Send(frame));
  return drive->Finish().status();
}

void Vehicle::WaitForAnswers(size_t count) {
  MutexLock lock(&mutex_);
  mutex_.Await(&Vehicle::HasAnswersOrEnded, this, count);
}

Testimony Vehicle::Finish() {
  thread_.join();
  MutexLock lock(&mutex_);
  return std::move(told_);
}

}  // namespace semmap::kill_test
