#include "tests/bench/experiment/recorded_drive.h"

#include <array>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/town/drive.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/trajectory_io.h"
#include "tests/bench/experiment/files.h"
#include "tests/bench/experiment/truth_label.h"

namespace semmap::bench {
namespace {

constexpr int kJpegQuality = 95;

std::string FolderOf(const std::string& folder, const DriveKey& key, const DriveSetup& setup) {
  std::string name = absl::StrCat(folder, "/", key.Name());
  if (setup.town_seed != 1) absl::StrAppend(&name, "_town", setup.town_seed);
  if (setup.vehicles != 20 || setup.pedestrians != 10)
    absl::StrAppend(&name, "_", setup.vehicles, "v", setup.pedestrians, "p");
  if (setup.weather != "noon") absl::StrAppend(&name, "_", setup.weather);
  if (setup.max_frames > 0) absl::StrAppend(&name, "_", setup.max_frames, "f");
  return name;
}

town::DriveConfig ConfigOf(const DriveKey& key, const DriveSetup& setup) {
  town::DriveConfig config;
  config.seed = setup.town_seed;
  config.traffic_seed = key.traffic_seed;
  config.route = key.route;
  config.traffic = {setup.vehicles, setup.pedestrians};
  config.weather = setup.weather;
  config.max_frames = setup.max_frames;
  return config;
}

absl::Status WriteFrame(const std::string& folder, const town::TownDrive& drive,
                        const town::DriveFrame& frame) {
  cv::Mat bgr;
  cv::cvtColor(frame.left.rgb, bgr, cv::COLOR_RGB2BGR);
  SEMMAP_RETURN_IF_ERROR(WriteImage(absl::StrFormat("%s/image/%06d.jpg", folder, frame.index), bgr,
                                    {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}));
  return WriteImage(absl::StrFormat("%s/truth/%06d.png", folder, frame.index), LabelTruth(drive, frame),
                    {cv::IMWRITE_PNG_COMPRESSION, 1});
}

}  // namespace

std::string DriveKey::Name() const { return absl::StrCat("route", route, "_seed", traffic_seed); }

std::string RecordedDrive::PathOf(const std::string& kind, int frame, const char* extension) const {
  return absl::StrFormat("%s/%s/%06d.%s", folder_, kind, frame, extension);
}

absl::Status RecordedDrive::Draw(const std::string& folder, const DriveKey& key, const DriveSetup& setup,
                                 const town::World& world, const std::function<void(int)>& progress) {
  for (const char* kind : {"image", "truth"})
    SEMMAP_RETURN_IF_ERROR(MakeFolders(absl::StrCat(folder, "/", kind)));
  SEMMAP_ASSIGN_OR_RETURN(const auto drive, town::TownDrive::Create(ConfigOf(key, setup), &world));
  town::DriveFrame frame;
  Trajectory truth;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool more, drive->Next(&frame));
    if (!more) break;
    SEMMAP_RETURN_IF_ERROR(WriteFrame(folder, *drive, frame));
    truth.poses.push_back({frame.timestamp_ns, frame.town_from_camera});
    progress(frame.index + 1);
  }
  SEMMAP_RETURN_IF_ERROR(
      WriteTrajectory(absl::StrCat(folder, "/poses_town.txt"), truth, TrajectoryFormat::kTum));
  // Its presence says that the drive is complete.
  return WriteJson(absl::StrCat(folder, "/drive.json"), {{"route", key.route},
                                                         {"traffic_seed", key.traffic_seed},
                                                         {"town_seed", setup.town_seed},
                                                         {"vehicles", setup.vehicles},
                                                         {"pedestrians", setup.pedestrians},
                                                         {"weather", setup.weather},
                                                         {"frames", truth.size()},
                                                         {"route_length_m", drive->route().path.length()}});
}

absl::StatusOr<RecordedDrive> RecordedDrive::Open(const std::string& folder, const DriveKey& key,
                                                  const DriveSetup& setup) {
  RecordedDrive recorded;
  recorded.folder_ = folder;
  recorded.key_ = key;
  SEMMAP_ASSIGN_OR_RETURN(const nlohmann::json description, ReadJson(absl::StrCat(folder, "/drive.json")));
  recorded.route_length_m_ = description.value("route_length_m", 0.0);
  SEMMAP_ASSIGN_OR_RETURN(recorded.truth_, ReadTumTrajectory(absl::StrCat(folder, "/poses_town.txt")));
  if (recorded.truth_.size() != description.value("frames", size_t{0}))
    return absl::DataLossError(absl::StrCat(folder, ": poses_town.txt and drive.json disagree"));
  const town::RigConfig rig = ConfigOf(key, setup).rig;
  recorded.rig_.sensor = SensorType::kMono;
  recorded.rig_.camera = rig.Intrinsics();
  recorded.rig_.frames_per_second = rig.frames_per_second;
  return recorded;
}

absl::StatusOr<RecordedDrive> RecordedDrive::Make(const std::string& folder, const DriveKey& key,
                                                  const DriveSetup& setup, const town::World& world,
                                                  const std::function<void(int)>& progress) {
  const std::string own = FolderOf(folder, key, setup);
  if (!FileExists(absl::StrCat(own, "/drive.json")))
    SEMMAP_RETURN_IF_ERROR(Draw(own, key, setup, world, progress));
  return Open(own, key, setup);
}

absl::StatusOr<cv::Mat> RecordedDrive::ReadImage(int frame) const {
  return ReadImageFile(PathOf("image", frame, "jpg"), cv::IMREAD_COLOR);
}

absl::StatusOr<cv::Mat> RecordedDrive::ReadLabels(int frame) const {
  return ReadImageFile(PathOf("truth", frame, "png"), cv::IMREAD_UNCHANGED);
}

absl::Status RecordedDrive::Segment(const std::string& model, Segmenter* segmenter, int step,
                                    const std::function<void(int)>& progress) const {
  const std::string confidence = model + "_confidence";
  for (const std::string& kind : {model, confidence})
    SEMMAP_RETURN_IF_ERROR(MakeFolders(absl::StrCat(folder_, "/", kind)));
  for (int frame = 0; frame < frames(); frame += step) {
    // The class mask is written last.
    if (FileExists(PathOf(model, frame, "png"))) continue;
    SEMMAP_ASSIGN_OR_RETURN(const cv::Mat image, ReadImage(frame));
    const std::array<cv::Mat, 1> batch = {image};
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<Segmentation> segmented, segmenter->Segment(batch));
    Masks masks;
    segmented.front().ToMasks(&masks.classes, &masks.confidence);
    SEMMAP_RETURN_IF_ERROR(
        WriteImage(PathOf(confidence, frame, "png"), masks.confidence, {cv::IMWRITE_PNG_COMPRESSION, 1}));
    SEMMAP_RETURN_IF_ERROR(
        WriteImage(PathOf(model, frame, "png"), masks.classes, {cv::IMWRITE_PNG_COMPRESSION, 1}));
    progress(frame + 1);
  }
  return absl::OkStatus();
}

absl::StatusOr<RecordedDrive::Masks> RecordedDrive::ReadMasks(const std::string& model, int frame) const {
  Masks masks;
  SEMMAP_ASSIGN_OR_RETURN(masks.classes, ReadImageFile(PathOf(model, frame, "png"), cv::IMREAD_UNCHANGED));
  SEMMAP_ASSIGN_OR_RETURN(masks.confidence,
                          ReadImageFile(PathOf(model + "_confidence", frame, "png"), cv::IMREAD_UNCHANGED));
  return masks;
}

}  // namespace semmap::bench
