#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/town/drive.h"

namespace semmap::town {

struct DatasetOptions {
  bool grey = false;  // grey images instead of colour, a third of the size
  bool mask = true;
  bool depth = true;
};

// Writes a drive as a folder in the layout of KITTI's odometry set, which `semmap drive --source kitti:`
// reads:
//   image_0/ image_1/   PNG, rectified; image_1 with stereo only
//   class/              8-bit PNG, CARLA's ids
//   depth/              16-bit PNG, millimetres along the optical axis; 0: sky, or farther than 65.535 m
//   calib.txt times.txt poses.txt   as KITTI's; poses are map_from_camera, the map being the first left
//   camera poses_town.txt      the same as town_from_camera, in the town's frame: east, north, up
//   odometry.csv gnss.csv town.json
class DatasetWriter {
 public:
  // Makes the folder; ALREADY_EXISTS when it holds something.
  static absl::StatusOr<std::unique_ptr<DatasetWriter>> Create(const std::string& folder,
                                                               const TownDrive& drive,
                                                               const DatasetOptions& options);
  absl::Status Write(const DriveFrame& frame);
  // Closes the text files; reports what did not fit on the disk.
  absl::Status Finish();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  using File = std::unique_ptr<std::FILE, CloseFile>;

  DatasetWriter(std::string folder, const DatasetOptions& options)
      : folder_(std::move(folder)), options_(options) {}
  absl::Status Open(const std::string& name, File* file) const;
  absl::Status WriteCalibration(const RigConfig& rig) const;
  absl::Status WriteDescription(const TownDrive& drive) const;
  absl::Status WriteImages(const DriveFrame& frame) const;
  void WriteTexts(const DriveFrame& frame);

  std::string folder_;
  DatasetOptions options_;
  File times_;
  File poses_;
  File poses_town_;
  File odometry_;
  File gnss_;
  int first_index_ = -1;
  SE3 first_camera_from_town_;
};

// Writes an RGB image (CV_8UC3) or one of a single channel as PNG; exceptions of the encoder come back as a
// status.
absl::Status WritePng(const std::string& path, const cv::Mat& rgb_or_grey);

}  // namespace semmap::town
