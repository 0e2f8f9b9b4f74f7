#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "client/sources/source_image.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/camera.h"

namespace semmap::client {

// One frame of a recording. Which images are set follows from the rig: mono `image`; stereo also `right`;
// RGB-D also `depth`.
struct SourceFrame {
  uint64_t sequence = 0;  // 0, 1, 2, ...
  TimestampNs timestamp = 0;
  SourceImage image;
  SourceImage right;
  SourceImage depth;
  SourceImage class_mask;  // the vehicle's own segmentation, if it has one
  std::optional<double> wheel_speed_m_s;
  // Of a satellite receiver, WGS84.
  struct GnssFix {
    double latitude_deg = 0;
    double longitude_deg = 0;
    double altitude_m = 0;
    double accuracy_m = 0;  // one standard deviation, horizontal
  };
  std::optional<GnssFix> gnss;
};

// A recording that can be played once from its beginning, one frame in memory at a time. Everything that can
// be known beforehand (calibration, file lists, ground truth) is read and checked when it is opened. Not
// thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  // Valid in the sense of ValidateRig, with the sensor that was asked for; frames are as large as it says.
  virtual const CameraRig& rig() const = 0;
  // Nothing when only playing it tells (some videos).
  virtual std::optional<size_t> frame_count() const = 0;
  // map_from_camera of the (left) camera, with times on the clock of the frames, in a map frame of its own. A
  // simulated vehicle knows it as far as it has driven.
  virtual const std::optional<Trajectory>& ground_truth() const = 0;
  // The next frame, nothing after the last, or why it cannot be read. Timestamps grow.
  virtual absl::StatusOr<std::optional<SourceFrame>> Next() = 0;
};

}  // namespace semmap::client
