#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/sources/frame_source.h"

namespace semmap::client {

// The files of one frame; `right`, `depth` and `class_mask` are empty where there are none.
struct FrameFiles {
  TimestampNs timestamp = 0;
  std::string image;
  std::string right;
  std::string depth;
  std::string class_mask = {};
};

// What the readers of data set folders find out; playing it is the same for all of them.
struct FileRecording {
  CameraRig rig;
  std::vector<FrameFiles> frames;
  std::optional<Trajectory> ground_truth;
};

// INVALID_ARGUMENT when the rig is not valid, there are no frames or times do not grow.
absl::StatusOr<std::unique_ptr<FrameSource>> MakeFileSource(FileRecording recording);

// Reads the files of frame number `sequence`.
absl::StatusOr<SourceFrame> ReadFrame(const FrameFiles& files, uint64_t sequence);

// One over the median time between frames; 10 for fewer than two.
double FrameRateOf(const std::vector<FrameFiles>& frames);

}  // namespace semmap::client
