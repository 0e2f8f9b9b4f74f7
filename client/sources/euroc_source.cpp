#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client/sources/euroc_calibration.h"
#include "client/sources/file_list.h"
#include "client/sources/file_source.h"
#include "client/sources/open_source.h"
#include "client/sources/stereo_rectifier.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/association.h"
#include "slam/evaluation/line_reader.h"

namespace semmap::client {
namespace {

// The cameras are triggered together; a partner further off in time is another frame.
constexpr double kMaxPairDifferenceS = 0.005;
constexpr size_t kGroundTruthFields = 8;  // time, position, quaternion; velocity and biases follow

struct TimedFiles {
  std::vector<TimestampNs> times;
  std::vector<std::string> paths;
};

absl::StatusOr<TimestampNs> NanosecondsOf(const LineReader& reader) {
  TimestampNs timestamp = 0;
  if (!absl::SimpleAtoi(reader.fields().front(), &timestamp)) {
    return reader.Error("the first field is not a time in nanoseconds");
  }
  return timestamp;
}

absl::StatusOr<TimedFiles> ReadImageList(const std::string& camera_folder) {
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(JoinPath(camera_folder, "data.csv")));
  const std::string data = JoinPath(camera_folder, "data");
  TimedFiles files;
  while (reader.Next()) {
    SEMMAP_ASSIGN_OR_RETURN(const TimestampNs timestamp, NanosecondsOf(reader));
    if (reader.fields().size() != 2) return reader.Error("expected a time and a file name");
    if (files.times.size() == kMaxFrames) return reader.Error("too many frames");
    if (!files.times.empty() && timestamp <= files.times.back()) {
      return reader.Error("the time is not later than the one before");
    }
    files.times.push_back(timestamp);
    files.paths.push_back(JoinPath(data, reader.fields()[1]));
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return files;
}

absl::StatusOr<std::optional<Trajectory>> ReadGroundTruth(const std::string& path,
                                                          const SE3& body_from_camera) {
  if (!FileExists(path)) return std::nullopt;
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(path));
  Trajectory trajectory;
  while (reader.Next()) {
    SEMMAP_ASSIGN_OR_RETURN(const TimestampNs timestamp, NanosecondsOf(reader));
    std::array<double, kGroundTruthFields> n{};
    for (size_t i = 1; i < kGroundTruthFields; ++i) {
      const std::optional<double> number = reader.Number(i);
      if (!number) return reader.Error("expected a time, a position and a quaternion");
      n[i] = *number;
    }
    const SE3 map_from_body(Eigen::Quaterniond(n[4], n[5], n[6], n[7]), Eigen::Vector3d(n[1], n[2], n[3]));
    if (!map_from_body.IsFinite()) return reader.Error("the quaternion is zero");
    if (trajectory.size() == kMaxFrames) return reader.Error("too many poses");
    trajectory.poses.push_back({timestamp, map_from_body * body_from_camera});
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return trajectory;
}

// Plays raw pairs through a rectifier.
class RectifiedSource : public FrameSource {
 public:
  RectifiedSource(std::unique_ptr<FrameSource> raw, StereoRectifier rectifier)
      : raw_(std::move(raw)), rectifier_(std::move(rectifier)) {}

  const CameraRig& rig() const override { return raw_->rig(); }
  std::optional<size_t> frame_count() const override { return raw_->frame_count(); }
  const std::optional<Trajectory>& ground_truth() const override { return raw_->ground_truth(); }

  absl::StatusOr<std::optional<SourceFrame>> Next() override {
    SEMMAP_ASSIGN_OR_RETURN(std::optional<SourceFrame> frame, raw_->Next());
    if (!frame) return frame;
    SEMMAP_ASSIGN_OR_RETURN(const cv::Mat left, DecodeGray(frame->image));
    SEMMAP_ASSIGN_OR_RETURN(const cv::Mat right, DecodeGray(frame->right));
    SEMMAP_ASSIGN_OR_RETURN(cv::Mat rectified_left, rectifier_.RectifyLeft(left));
    SEMMAP_ASSIGN_OR_RETURN(cv::Mat rectified_right, rectifier_.RectifyRight(right));
    frame->image = {frame->image.path, ImageEncoding::kNone, "", std::move(rectified_left)};
    frame->right = {frame->right.path, ImageEncoding::kNone, "", std::move(rectified_right)};
    return frame;
  }

 private:
  std::unique_ptr<FrameSource> raw_;
  StereoRectifier rectifier_;
};

absl::StatusOr<std::unique_ptr<FrameSource>> OpenMono(const std::string& root) {
  SEMMAP_ASSIGN_OR_RETURN(const EurocCamera camera, ReadEurocCamera(JoinPath(root, "cam0/sensor.yaml")));
  SEMMAP_ASSIGN_OR_RETURN(const TimedFiles files, ReadImageList(JoinPath(root, "cam0")));
  FileRecording recording;
  recording.rig.sensor = SensorType::kMono;
  recording.rig.camera = camera.intrinsics;
  recording.rig.frames_per_second = camera.frames_per_second;
  recording.rig.body_from_camera = camera.body_from_camera;
  for (size_t i = 0; i < files.times.size(); ++i) {
    recording.frames.push_back({files.times[i], files.paths[i], "", ""});
  }
  SEMMAP_ASSIGN_OR_RETURN(
      recording.ground_truth,
      ReadGroundTruth(JoinPath(root, "state_groundtruth_estimate0/data.csv"), camera.body_from_camera));
  return MakeFileSource(std::move(recording));
}

absl::StatusOr<std::unique_ptr<FrameSource>> OpenStereo(const std::string& root) {
  SEMMAP_ASSIGN_OR_RETURN(const EurocCamera left, ReadEurocCamera(JoinPath(root, "cam0/sensor.yaml")));
  SEMMAP_ASSIGN_OR_RETURN(const EurocCamera right, ReadEurocCamera(JoinPath(root, "cam1/sensor.yaml")));
  SEMMAP_ASSIGN_OR_RETURN(const TimedFiles left_files, ReadImageList(JoinPath(root, "cam0")));
  SEMMAP_ASSIGN_OR_RETURN(const TimedFiles right_files, ReadImageList(JoinPath(root, "cam1")));
  const SE3 right_from_left = right.body_from_camera.Inverse() * left.body_from_camera;
  SEMMAP_ASSIGN_OR_RETURN(StereoRectifier rectifier,
                          StereoRectifier::Create(left.intrinsics, right.intrinsics, right_from_left));
  FileRecording recording;
  recording.rig.sensor = SensorType::kStereo;
  recording.rig.camera = rectifier.camera();
  recording.rig.baseline_m = rectifier.baseline_m();
  recording.rig.frames_per_second = left.frames_per_second;
  recording.rig.body_from_camera = left.body_from_camera * rectifier.left_from_rectified();
  for (const TimeMatch& match : MatchTimes(right_files.times, left_files.times, kMaxPairDifferenceS)) {
    recording.frames.push_back(
        {left_files.times[match.second], left_files.paths[match.second], right_files.paths[match.first], ""});
  }
  SEMMAP_ASSIGN_OR_RETURN(recording.ground_truth,
                          ReadGroundTruth(JoinPath(root, "state_groundtruth_estimate0/data.csv"),
                                          recording.rig.body_from_camera));
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<FrameSource> raw, MakeFileSource(std::move(recording)));
  return std::make_unique<RectifiedSource>(std::move(raw), std::move(rectifier));
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenEurocSource(const std::string& folder,
                                                             const SourceOptions& options) {
  if (options.sensor == SensorType::kRgbd)
    return absl::InvalidArgumentError("a EuRoC folder has no depth images");
  if (!options.camera_file.empty()) {
    return absl::InvalidArgumentError("a EuRoC folder brings its calibration: --camera does not apply");
  }
  const std::string inner = JoinPath(folder, "mav0");
  const std::string root = FolderExists(inner) ? inner : folder;
  return options.sensor == SensorType::kStereo ? OpenStereo(root) : OpenMono(root);
}

}  // namespace semmap::client
