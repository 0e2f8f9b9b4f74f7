#pragma once

#include <string>

#include "absl/time/time.h"
#include "slam/common/fwd.h"

namespace semmap {

// Which frames of a session go through the network. Frames that bring a mask of their own never do.
enum class SegmentationMode {
  kOff,
  kEveryFrame,  // beside the extraction of features
  kKeyFrames,   // keyframes alone, beside tracking: the mapper waits for their classes
};

struct SegmentationConfig {
  SegmentationMode mode = SegmentationMode::kOff;
  // Takes the place of `mode`, unless that is off, for vehicles whose frames are dropped rather than kept
  // waiting: a CPU that segments every frame falls behind a camera.
  SegmentationMode live_mode = SegmentationMode::kKeyFrames;
  std::string model;  // path of a SegmentationModel; empty: DefaultSegmentationModelPath()
  // Of the network; 0: as many as the machine has cores. On the CPU that was measured neither a second thread
  // nor a batch paid (docs/results.md).
  int threads = 1;
  // Of the queue that all sessions share.
  int max_batch = 1;
  int max_waiting = 128;
  // How long a frame waits for its classes after its features are there, and a keyframe in the mapper; 0: as
  // long as it takes. A frame that waited in vain goes without classes.
  double max_wait_ms = 100;

  absl::Duration max_wait() const;
  void Read(ConfigReader& reader);
};

}  // namespace semmap
