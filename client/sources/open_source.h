#pragma once

#include <memory>
#include <string>

#include "client/sources/frame_source.h"

namespace semmap::client {

struct SourceOptions {
  SensorType sensor = SensorType::kMono;
  // A calibration that overrides the recording's own; needed for videos, and for image folders without
  // camera.yaml.
  std::string camera_file;
  // Frames bring the class masks of the recording: images of class ids in its subfolder `class`, named like
  // the left ones (KITTI layout) or in their order (image folder).
  bool class_masks = false;
};

// Opens "kitti:DIR", "tum:DIR", "euroc:DIR", "folder:DIR" or "video:FILE". INVALID_ARGUMENT for another kind
// and for what the recording cannot give (a second camera, depth), else the reader's own status.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenSource(const std::string& spec,
                                                        const SourceOptions& options);

// Whether the text has the form KIND:PATH of a known kind.
bool IsSourceSpec(const std::string& spec);

// One line for --help.
const char* SourceSpecHelp();

// The readers behind OpenSource; each header comment says what it expects.

// KITTI odometry: image_0 (and image_1), else image_2 (and image_3); calib.txt; times.txt; optionally
// poses.txt.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenKittiSource(const std::string& folder,
                                                             const SourceOptions& options);

// TUM RGB-D: associations.txt, or rgb.txt and depth.txt, which are associated by time; optionally
// groundtruth.txt. Calibration: camera.yaml in the folder, else camera-intrinsics.txt (a 3x3 matrix; depth in
// millimetres), else the published one for a folder whose name has freiburg1, 2 or 3, else TUM's default
// (525, 319.5, 239.5).
absl::StatusOr<std::unique_ptr<FrameSource>> OpenTumSource(const std::string& folder,
                                                           const SourceOptions& options);

// EuRoC MAV: mav0 (or the folder itself) with cam0, cam1, optionally state_groundtruth_estimate0. Stereo
// pairs are rectified here; a single camera is played raw with its distortion.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenEurocSource(const std::string& folder,
                                                             const SourceOptions& options);

// A folder of images in natural order, or with subfolders left, right and depth (also: image_0 and image_1,
// rgb); camera.yaml or --camera; optionally times.txt (else the camera file's frame rate), groundtruth.txt
// (TUM format) or poses.txt (KITTI format).
absl::StatusOr<std::unique_ptr<FrameSource>> OpenFolderSource(const std::string& folder,
                                                              const SourceOptions& options);

// A video that OpenCV can play, of one camera, with --camera.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenVideoSource(const std::string& file,
                                                             const SourceOptions& options);

}  // namespace semmap::client
