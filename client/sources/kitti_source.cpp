#include <array>
#include <filesystem>
#include <map>

#include "absl/strings/str_cat.h"
#include "client/sources/camera_file.h"
#include "client/sources/file_list.h"
#include "client/sources/file_source.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/line_reader.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::client {
namespace {

using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;

// The pair of cameras that is used: grey if there, else colour.
struct CameraPair {
  std::string left_folder;
  std::string right_folder;
  std::string left_key;
  std::string right_key;
};

CameraPair ChooseCameras(const std::string& folder) {
  if (FolderExists(JoinPath(folder, "image_0"))) {
    return {JoinPath(folder, "image_0"), JoinPath(folder, "image_1"), "P0:", "P1:"};
  }
  return {JoinPath(folder, "image_2"), JoinPath(folder, "image_3"), "P2:", "P3:"};
}

absl::StatusOr<std::map<std::string, ProjectionMatrix>> ReadCalibration(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(path));
  std::map<std::string, ProjectionMatrix> matrices;
  while (reader.Next()) {
    const std::string key(reader.fields().front());
    if (key.front() != 'P') continue;  // Tr: is the laser's
    ProjectionMatrix matrix;
    for (int i = 0; i < 12; ++i) {
      const std::optional<double> number = reader.Number(static_cast<size_t>(i) + 1);
      if (!number) return reader.Error(absl::StrCat(key, " needs the 12 numbers of a 3x4 matrix"));
      matrix(i / 4, i % 4) = *number;
    }
    matrices[key] = matrix;
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return matrices;
}

absl::StatusOr<ProjectionMatrix> FindMatrix(const std::map<std::string, ProjectionMatrix>& matrices,
                                            const std::string& key, const std::string& path) {
  const auto found = matrices.find(key);
  if (found == matrices.end()) return absl::InvalidArgumentError(absl::StrCat(path, ": has no line ", key));
  return found->second;
}

// Where the camera sits in the frame of camera 0, in which the poses are given: P = K [I | K^-1 p4].
Eigen::Vector3d PositionInCamera0(const ProjectionMatrix& projection) {
  return -projection.leftCols<3>().inverse() * projection.col(3);
}

struct Calibration {
  CameraRig rig;
  SE3 camera0_from_camera;
};

absl::StatusOr<Calibration> Calibrate(const std::string& folder, const CameraPair& cameras,
                                      SensorType sensor) {
  const std::string path = JoinPath(folder, "calib.txt");
  SEMMAP_ASSIGN_OR_RETURN(const auto matrices, ReadCalibration(path));
  SEMMAP_ASSIGN_OR_RETURN(const ProjectionMatrix left, FindMatrix(matrices, cameras.left_key, path));
  Calibration calibration;
  CameraRig& rig = calibration.rig;
  rig.sensor = sensor;
  rig.camera.fx = left(0, 0);
  rig.camera.fy = left(1, 1);
  rig.camera.cx = left(0, 2);
  rig.camera.cy = left(1, 2);
  calibration.camera0_from_camera = SE3(Eigen::Quaterniond::Identity(), PositionInCamera0(left));
  if (sensor == SensorType::kStereo) {
    SEMMAP_ASSIGN_OR_RETURN(const ProjectionMatrix right, FindMatrix(matrices, cameras.right_key, path));
    rig.baseline_m = PositionInCamera0(right).x() - PositionInCamera0(left).x();
  }
  return calibration;
}

// The file beside the left image's that has its name and lies in another folder.
absl::StatusOr<std::string> Partner(const std::string& folder, const std::string& image) {
  std::string path = JoinPath(folder, std::filesystem::path(image).filename().string());
  if (!FileExists(path)) return absl::NotFoundError(absl::StrCat(path, ": no such image"));
  return path;
}

absl::StatusOr<std::vector<FrameFiles>> ListFrames(const CameraPair& cameras, const std::string& class_folder,
                                                   SensorType sensor, const std::vector<TimestampNs>& times) {
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> images, ListImages(cameras.left_folder));
  if (times.size() < images.size()) {
    return absl::InvalidArgumentError(absl::StrCat("times.txt has ", times.size(), " lines for ",
                                                   images.size(), " images in ", cameras.left_folder));
  }
  std::vector<FrameFiles> frames;
  for (size_t i = 0; i < images.size(); ++i) {
    FrameFiles files{times[i], images[i], "", ""};
    if (sensor == SensorType::kStereo) {
      SEMMAP_ASSIGN_OR_RETURN(files.right, Partner(cameras.right_folder, images[i]));
    }
    if (!class_folder.empty()) {
      SEMMAP_ASSIGN_OR_RETURN(files.class_mask, Partner(class_folder, images[i]));
    }
    frames.push_back(std::move(files));
  }
  return frames;
}

absl::StatusOr<std::optional<Trajectory>> ReadPoses(const std::string& path,
                                                    const std::vector<TimestampNs>& times,
                                                    const SE3& camera0_from_camera) {
  if (!FileExists(path)) return std::nullopt;
  SEMMAP_ASSIGN_OR_RETURN(Trajectory trajectory, ReadKittiTrajectory(path));
  SEMMAP_RETURN_IF_ERROR(AttachTimes(times, &trajectory));
  for (StampedPose& pose : trajectory.poses)
    pose.map_from_camera = pose.map_from_camera * camera0_from_camera;
  return trajectory;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenKittiSource(const std::string& folder,
                                                             const SourceOptions& options) {
  if (options.sensor == SensorType::kRgbd)
    return absl::InvalidArgumentError("a KITTI folder has no depth images");
  const CameraPair cameras = ChooseCameras(folder);
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TimestampNs> times, ReadTimes(JoinPath(folder, "times.txt")));
  const std::string class_folder = options.class_masks ? JoinPath(folder, "class") : "";
  FileRecording recording;
  SEMMAP_ASSIGN_OR_RETURN(recording.frames, ListFrames(cameras, class_folder, options.sensor, times));
  Calibration calibration;
  if (options.camera_file.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(calibration, Calibrate(folder, cameras, options.sensor));
    SEMMAP_ASSIGN_OR_RETURN(const cv::Size size, ImageSizeOf(recording.frames.front().image));
    calibration.rig.camera.width = size.width;
    calibration.rig.camera.height = size.height;
    calibration.rig.frames_per_second = FrameRateOf(recording.frames);
  } else {
    SEMMAP_ASSIGN_OR_RETURN(calibration.rig, ReadCameraFile(options.camera_file, options.sensor));
  }
  recording.rig = calibration.rig;
  SEMMAP_ASSIGN_OR_RETURN(recording.ground_truth,
                          ReadPoses(JoinPath(folder, "poses.txt"), times, calibration.camera0_from_camera));
  return MakeFileSource(std::move(recording));
}

}  // namespace semmap::client
