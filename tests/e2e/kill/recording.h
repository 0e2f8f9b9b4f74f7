#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "semmap/v1/camera.pb.h"
#include "semmap/v1/frame.pb.h"
#include "slam/geometry/camera.h"

namespace semmap::kill_test {

// What a vehicle sends, all of it in memory: frame i has sequence i + 1.
struct Recording {
  v1::CameraRig rig;
  std::vector<v1::Frame> frames;
};

// The first frames of a source, see client::SourceSpecHelp().
absl::StatusOr<Recording> ReadRecording(const std::string& source, SensorType sensor, size_t max_frames);

// A stereo vehicle drives a circle in a textured room and goes on for a while where it began: a drive with a
// loop, drawn in seconds.
absl::StatusOr<Recording> DrawRoundTrip();

}  // namespace semmap::kill_test
