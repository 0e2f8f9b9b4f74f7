#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <opencv2/core/mat.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/town/world.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/camera.h"
#include "slam/semantics/segmenter.h"

namespace semmap::bench {

// Which drive: a route of the town through the traffic of a seed.
struct DriveKey {
  std::string route = "1";
  uint64_t traffic_seed = 1;

  std::string Name() const;  // "route1_seed1"
};

struct DriveSetup {
  uint64_t town_seed = 1;
  int vehicles = 20;
  int pedestrians = 10;
  std::string weather = "noon";
  int max_frames = 0;  // 0: the whole route
};

// One drive through the town on disk, so that drawing it, which takes longest, is done once: images as JPEG
// (as a vehicle would send them), encoded TruthLabels as PNG, the truth in the town's frame, and the masks of
// models.
class RecordedDrive {
 public:
  // Draws the drive into a subfolder of `folder` unless it is there in full. `progress` is called after each
  // frame.
  static absl::StatusOr<RecordedDrive> Make(const std::string& folder, const DriveKey& key,
                                            const DriveSetup& setup, const town::World& world,
                                            const std::function<void(int)>& progress);

  const DriveKey& key() const { return key_; }
  int frames() const { return static_cast<int>(truth_.size()); }
  const CameraRig& rig() const { return rig_; }
  // town_from_camera of each frame.
  const Trajectory& truth() const { return truth_; }
  double route_length_m() const { return route_length_m_; }

  absl::StatusOr<cv::Mat> ReadImage(int frame) const;   // CV_8UC3, BGR
  absl::StatusOr<cv::Mat> ReadLabels(int frame) const;  // CV_8UC1, encoded

  // Class and confidence masks, CV_8UC1.
  struct Masks {
    cv::Mat classes;
    cv::Mat confidence;
  };
  // Segments every `step`-th frame and keeps the masks under the model's name, unless they are there.
  absl::Status Segment(const std::string& model, Segmenter* segmenter, int step,
                       const std::function<void(int)>& progress) const;
  absl::StatusOr<Masks> ReadMasks(const std::string& model, int frame) const;

 private:
  RecordedDrive() = default;
  static absl::Status Draw(const std::string& folder, const DriveKey& key, const DriveSetup& setup,
                           const town::World& world, const std::function<void(int)>& progress);
  static absl::StatusOr<RecordedDrive> Open(const std::string& folder, const DriveKey& key,
                                            const DriveSetup& setup);
  std::string PathOf(const std::string& kind, int frame, const char* extension) const;

  std::string folder_;
  DriveKey key_;
  CameraRig rig_;
  Trajectory truth_;
  double route_length_m_ = 0;
};

}  // namespace semmap::bench
