#include <initializer_list>

#include "absl/strings/str_cat.h"
#include "client/sources/camera_file.h"
#include "client/sources/file_list.h"
#include "client/sources/file_source.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::client {
namespace {

using Paths = std::vector<std::string>;

std::string FirstSubfolder(const std::string& folder, std::initializer_list<const char*> names,
                           const std::string& otherwise) {
  for (const char* name : names) {
    if (FolderExists(JoinPath(folder, name))) return JoinPath(folder, name);
  }
  return otherwise;
}

// The second image of each frame, paired by position in the natural order.
absl::StatusOr<Paths> ListPartners(const std::string& folder, size_t count, const char* what) {
  if (folder.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("the folder has no subfolder with ", what, " images"));
  }
  SEMMAP_ASSIGN_OR_RETURN(Paths paths, ListImages(folder));
  if (paths.size() != count) {
    return absl::InvalidArgumentError(
        absl::StrCat(folder, ": has ", paths.size(), " images for ", count, " frames"));
  }
  return paths;
}

absl::StatusOr<std::vector<FrameFiles>> ListFrames(const std::string& folder, const SourceOptions& options) {
  const SensorType sensor = options.sensor;
  SEMMAP_ASSIGN_OR_RETURN(const Paths images,
                          ListImages(FirstSubfolder(folder, {"left", "image_0", "rgb"}, folder)));
  std::vector<FrameFiles> frames(images.size());
  for (size_t i = 0; i < images.size(); ++i) frames[i].image = images[i];
  if (sensor == SensorType::kStereo) {
    const std::string right = FirstSubfolder(folder, {"right", "image_1"}, "");
    SEMMAP_ASSIGN_OR_RETURN(const Paths paths, ListPartners(right, images.size(), "right"));
    for (size_t i = 0; i < images.size(); ++i) frames[i].right = paths[i];
  }
  if (sensor == SensorType::kRgbd) {
    const std::string depth = FirstSubfolder(folder, {"depth"}, "");
    SEMMAP_ASSIGN_OR_RETURN(const Paths paths, ListPartners(depth, images.size(), "depth"));
    for (size_t i = 0; i < images.size(); ++i) frames[i].depth = paths[i];
  }
  if (options.class_masks) {
    const std::string classes = FirstSubfolder(folder, {"class"}, "");
    SEMMAP_ASSIGN_OR_RETURN(const Paths paths, ListPartners(classes, images.size(), "class"));
    for (size_t i = 0; i < images.size(); ++i) frames[i].class_mask = paths[i];
  }
  return frames;
}

absl::Status SetTimes(const std::string& folder, double frames_per_second, std::vector<FrameFiles>* frames) {
  const std::string path = JoinPath(folder, "times.txt");
  std::vector<TimestampNs> times;
  if (FileExists(path)) {
    SEMMAP_ASSIGN_OR_RETURN(times, ReadTimes(path));
    if (times.size() < frames->size()) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": has ", times.size(), " lines for ", frames->size(), " images"));
    }
  }
  for (size_t i = 0; i < frames->size(); ++i) {
    (*frames)[i].timestamp =
        times.empty() ? FromSeconds(static_cast<double>(i) / frames_per_second) : times[i];
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<Trajectory>> ReadGroundTruth(const std::string& folder,
                                                          const std::vector<FrameFiles>& frames) {
  if (FileExists(JoinPath(folder, "groundtruth.txt"))) {
    return ReadTumTrajectory(JoinPath(folder, "groundtruth.txt"));
  }
  const std::string path = JoinPath(folder, "poses.txt");
  if (!FileExists(path)) return std::nullopt;
  SEMMAP_ASSIGN_OR_RETURN(Trajectory trajectory, ReadKittiTrajectory(path));
  std::vector<TimestampNs> times;
  times.reserve(frames.size());
  for (const FrameFiles& files : frames) times.push_back(files.timestamp);
  SEMMAP_RETURN_IF_ERROR(AttachTimes(times, &trajectory));
  return trajectory;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenFolderSource(const std::string& folder,
                                                              const SourceOptions& options) {
  const std::string own = JoinPath(folder, "camera.yaml");
  const std::string camera_file = options.camera_file.empty() ? own : options.camera_file;
  if (!FileExists(camera_file)) {
    return absl::NotFoundError(absl::StrCat(camera_file, ": no such camera file; name one with --camera"));
  }
  FileRecording recording;
  SEMMAP_ASSIGN_OR_RETURN(recording.rig, ReadCameraFile(camera_file, options.sensor));
  SEMMAP_ASSIGN_OR_RETURN(recording.frames, ListFrames(folder, options));
  SEMMAP_RETURN_IF_ERROR(SetTimes(folder, recording.rig.frames_per_second, &recording.frames));
  SEMMAP_ASSIGN_OR_RETURN(recording.ground_truth, ReadGroundTruth(folder, recording.frames));
  return MakeFileSource(std::move(recording));
}

}  // namespace semmap::client
