#pragma once

#include <memory>

#include "client/sources/frame_source.h"
#include "client/town/drive.h"

namespace semmap::client {

// How a simulated vehicle sends what it sees.
struct TownSourceOptions {
  bool grey = false;
  bool class_mask = false;  // as if the vehicle segmented its images, perfectly
  int jpeg_quality = 0;     // 1 to 100; 0: raw pixels
};

// A vehicle of the simulated town as a source of frames: each is drawn when it is asked for. The truth grows
// with the drive and stays with the source.
class TownSource : public FrameSource {
 public:
  // The status of TownDrive::Create.
  static absl::StatusOr<std::unique_ptr<TownSource>> Create(const town::DriveConfig& config,
                                                            const TownSourceOptions& options);

  const CameraRig& rig() const override { return rig_; }
  // Known only when the drive was limited: traffic decides how long a route takes.
  std::optional<size_t> frame_count() const override;
  const std::optional<Trajectory>& ground_truth() const override { return truth_; }
  absl::StatusOr<std::optional<SourceFrame>> Next() override;

 private:
  TownSource(std::unique_ptr<town::TownDrive> drive, const TownSourceOptions& options);
  absl::StatusOr<SourceImage> Encode(const cv::Mat& rgb) const;

  std::unique_ptr<town::TownDrive> drive_;
  TownSourceOptions options_;
  CameraRig rig_;
  std::optional<Trajectory> truth_;
  SE3 map_from_town_;  // the map's frame is the first camera's
  town::DriveFrame frame_;
};

}  // namespace semmap::client
