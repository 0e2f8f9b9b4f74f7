#include <array>
#include <filesystem>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/sources/camera_file.h"
#include "client/sources/file_list.h"
#include "client/sources/file_source.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/association.h"
#include "slam/evaluation/line_reader.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::client {
namespace {

constexpr double kTumDepthUnits = 5000;
constexpr double kMillimetreUnits = 1000;

struct PublishedCalibration {
  const char* name;
  double fx, fy, cx, cy;
  std::array<double, 5> distortion;
};

// From the data set's page, "intrinsic camera calibration of the Kinect", the RGB cameras. Freiburg 3 is
// published undistorted.
constexpr std::array<PublishedCalibration, 3> kPublished = {{
    {"freiburg1", 517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
    {"freiburg2", 520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
    {"freiburg3", 535.4, 539.2, 320.1, 247.6, {0, 0, 0, 0, 0}},
}};
constexpr PublishedCalibration kDefault = {"", 525.0, 525.0, 319.5, 239.5, {0, 0, 0, 0, 0}};

struct TimedFile {
  TimestampNs timestamp = 0;
  std::string path;
};

CameraRig RigOf(const PublishedCalibration& published) {
  CameraRig rig;
  rig.camera.fx = published.fx;
  rig.camera.fy = published.fy;
  rig.camera.cx = published.cx;
  rig.camera.cy = published.cy;
  rig.camera.distortion = published.distortion;
  if (published.distortion[0] != 0) rig.camera.distortion_model = DistortionModel::kRadialTangential;
  rig.depth_units_per_metre = kTumDepthUnits;
  return rig;
}

CameraRig PublishedRig(const std::string& folder) {
  const std::string name = std::filesystem::weakly_canonical(folder).filename().string();
  for (const PublishedCalibration& published : kPublished) {
    if (absl::StrContains(name, published.name)) return RigOf(published);
  }
  return RigOf(kDefault);
}

// camera-intrinsics.txt: the calibration matrix; depth beside it is in millimetres (as 7-Scenes and Redwood
// have it).
absl::StatusOr<CameraRig> ReadIntrinsicMatrix(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(path));
  Eigen::Matrix3d matrix;
  int row = 0;
  for (; row < 3 && reader.Next(); ++row) {
    for (int column = 0; column < 3; ++column) {
      const std::optional<double> number = reader.Number(static_cast<size_t>(column));
      if (!number) return reader.Error("expected the three numbers of a row of a 3x3 matrix");
      matrix(row, column) = *number;
    }
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  if (row < 3) return absl::InvalidArgumentError(absl::StrCat(path, ": expected a 3x3 matrix"));
  CameraRig rig;
  rig.camera.fx = matrix(0, 0);
  rig.camera.fy = matrix(1, 1);
  rig.camera.cx = matrix(0, 2);
  rig.camera.cy = matrix(1, 2);
  rig.depth_units_per_metre = kMillimetreUnits;
  return rig;
}

absl::StatusOr<CameraRig> CalibrateFrom(const std::string& folder, const std::vector<FrameFiles>& frames) {
  const std::string matrix = JoinPath(folder, "camera-intrinsics.txt");
  CameraRig rig = PublishedRig(folder);
  if (FileExists(matrix)) {
    SEMMAP_ASSIGN_OR_RETURN(rig, ReadIntrinsicMatrix(matrix));
  }
  SEMMAP_ASSIGN_OR_RETURN(const cv::Size size, ImageSizeOf(frames.front().image));
  rig.camera.width = size.width;
  rig.camera.height = size.height;
  rig.frames_per_second = FrameRateOf(frames);
  return rig;
}

absl::StatusOr<CameraRig> Calibrate(const std::string& folder, const SourceOptions& options,
                                    const std::vector<FrameFiles>& frames) {
  if (!options.camera_file.empty()) return ReadCameraFile(options.camera_file, options.sensor);
  const std::string own = JoinPath(folder, "camera.yaml");
  if (FileExists(own)) return ReadCameraFile(own, options.sensor);
  SEMMAP_ASSIGN_OR_RETURN(CameraRig rig, CalibrateFrom(folder, frames));
  rig.sensor = options.sensor;
  return rig;
}

// rgb.txt or depth.txt: "seconds path".
absl::StatusOr<std::vector<TimedFile>> ReadFileList(const std::string& folder, const char* name) {
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(JoinPath(folder, name)));
  std::vector<TimedFile> files;
  while (reader.Next()) {
    const std::optional<TimestampNs> timestamp = reader.Seconds(0);
    if (!timestamp || reader.fields().size() != 2) return reader.Error("expected a time and a file name");
    if (files.size() == kMaxFrames) return reader.Error("too many frames");
    if (!files.empty() && *timestamp <= files.back().timestamp) {
      return reader.Error("the time is not later than the one before");
    }
    files.push_back({*timestamp, JoinPath(folder, reader.fields()[1])});
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return files;
}

// associations.txt: "seconds colour seconds depth", or depth first.
absl::StatusOr<std::vector<FrameFiles>> ReadAssociations(const std::string& folder, const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(path));
  std::vector<FrameFiles> frames;
  while (reader.Next()) {
    if (reader.fields().size() != 4) return reader.Error("expected time, image, time, depth image");
    const size_t image = absl::StartsWith(reader.fields()[1], "depth") ? 2 : 0;
    const std::optional<TimestampNs> timestamp = reader.Seconds(image);
    if (!timestamp) return reader.Error("the image has no time in seconds");
    if (frames.size() == kMaxFrames) return reader.Error("too many frames");
    frames.push_back({*timestamp, JoinPath(folder, reader.fields()[image + 1]), "",
                      JoinPath(folder, reader.fields()[3 - image])});
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return frames;
}

std::vector<TimestampNs> TimesOf(const std::vector<TimedFile>& files) {
  std::vector<TimestampNs> times;
  times.reserve(files.size());
  for (const TimedFile& file : files) times.push_back(file.timestamp);
  return times;
}

absl::StatusOr<std::vector<FrameFiles>> ListFrames(const std::string& folder, SensorType sensor) {
  const std::string associations = JoinPath(folder, "associations.txt");
  const bool associated = FileExists(associations);
  std::vector<FrameFiles> frames;
  if (sensor == SensorType::kRgbd && associated) return ReadAssociations(folder, associations);
  if (sensor == SensorType::kMono && associated && !FileExists(JoinPath(folder, "rgb.txt"))) {
    SEMMAP_ASSIGN_OR_RETURN(frames, ReadAssociations(folder, associations));
    for (FrameFiles& files : frames) files.depth.clear();
    return frames;
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TimedFile> images, ReadFileList(folder, "rgb.txt"));
  if (sensor == SensorType::kMono) {
    for (const TimedFile& image : images) frames.push_back({image.timestamp, image.path, "", ""});
    return frames;
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TimedFile> depths, ReadFileList(folder, "depth.txt"));
  for (const TimeMatch& match : MatchTimes(TimesOf(depths), TimesOf(images), kDefaultMaxTimeDifferenceS)) {
    const TimedFile& image = images[match.second];
    frames.push_back({image.timestamp, image.path, "", depths[match.first].path});
  }
  return frames;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenTumSource(const std::string& folder,
                                                           const SourceOptions& options) {
  if (options.sensor == SensorType::kStereo) {
    return absl::InvalidArgumentError("a TUM RGB-D folder has no second camera");
  }
  FileRecording recording;
  SEMMAP_ASSIGN_OR_RETURN(recording.frames, ListFrames(folder, options.sensor));
  if (recording.frames.empty()) return absl::InvalidArgumentError(absl::StrCat(folder, ": lists no frames"));
  SEMMAP_ASSIGN_OR_RETURN(recording.rig, Calibrate(folder, options, recording.frames));
  const std::string truth = JoinPath(folder, "groundtruth.txt");
  if (FileExists(truth)) {
    SEMMAP_ASSIGN_OR_RETURN(recording.ground_truth, ReadTumTrajectory(truth));
  }
  return MakeFileSource(std::move(recording));
}

}  // namespace semmap::client
