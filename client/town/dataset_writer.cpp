#include "client/town/dataset_writer.h"

#include <filesystem>
#include <system_error>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/common/status_macros.h"

namespace semmap::town {
namespace {

namespace fs = std::filesystem;

absl::Status MakeFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  return error ? absl::InternalError(absl::StrCat("cannot make ", path, ": ", error.message()))
               : absl::OkStatus();
}

void PrintPose(std::FILE* file, const SE3& pose) {
  const Eigen::Matrix4d m = pose.Matrix();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      std::fprintf(file, "%.9g%c", m(row, column), row == 2 && column == 3 ? '\n' : ' ');
    }
  }
}

}  // namespace

absl::Status WritePng(const std::string& path, const cv::Mat& rgb_or_grey) {
  try {
    cv::Mat bgr;  // of its own: the caller's pixels stay as they are
    if (rgb_or_grey.channels() == 3) cv::cvtColor(rgb_or_grey, bgr, cv::COLOR_RGB2BGR);
    const cv::Mat& image = bgr.empty() ? rgb_or_grey : bgr;
    if (cv::imwrite(path, image, {cv::IMWRITE_PNG_COMPRESSION, 1})) return absl::OkStatus();
    return absl::InternalError(absl::StrCat("cannot write ", path));
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("cannot write ", path, ": ", error.what()));
  }
}

absl::StatusOr<std::unique_ptr<DatasetWriter>> DatasetWriter::Create(const std::string& folder,
                                                                     const TownDrive& drive,
                                                                     const DatasetOptions& options) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    return absl::AlreadyExistsError(absl::StrCat(folder, " exists and is not empty"));
  }
  std::unique_ptr<DatasetWriter> writer(new DatasetWriter(folder, options));
  std::vector<std::string> folders = {"image_0"};
  if (drive.config().stereo) folders.emplace_back("image_1");
  if (options.mask) folders.emplace_back("class");
  if (options.depth) folders.emplace_back("depth");
  for (const std::string& name : folders) SEMMAP_RETURN_IF_ERROR(MakeFolder(absl::StrCat(folder, "/", name)));
  SEMMAP_RETURN_IF_ERROR(writer->Open("times.txt", &writer->times_));
  SEMMAP_RETURN_IF_ERROR(writer->Open("poses.txt", &writer->poses_));
  SEMMAP_RETURN_IF_ERROR(writer->Open("poses_town.txt", &writer->poses_town_));
  SEMMAP_RETURN_IF_ERROR(writer->Open("odometry.csv", &writer->odometry_));
  SEMMAP_RETURN_IF_ERROR(writer->Open("gnss.csv", &writer->gnss_));
  std::fputs("timestamp_ns,wheel_speed_mps,true_speed_mps\n", writer->odometry_.get());
  std::fputs("timestamp_ns,latitude,longitude,altitude,deviation_m\n", writer->gnss_.get());
  SEMMAP_RETURN_IF_ERROR(writer->WriteCalibration(drive.config().rig));
  SEMMAP_RETURN_IF_ERROR(writer->WriteDescription(drive));
  return writer;
}

absl::Status DatasetWriter::Open(const std::string& name, File* file) const {
  const std::string path = absl::StrCat(folder_, "/", name);
  file->reset(std::fopen(path.c_str(), "w"));
  return *file != nullptr ? absl::OkStatus() : absl::InternalError(absl::StrCat("cannot write ", path));
}

absl::Status DatasetWriter::WriteCalibration(const RigConfig& rig) const {
  File file;
  SEMMAP_RETURN_IF_ERROR(Open("calib.txt", &file));
  const CameraIntrinsics camera = rig.Intrinsics();
  for (const int index : {0, 1}) {
    std::fprintf(file.get(), "P%d: %.9g 0 %.9g %.9g 0 %.9g %.9g 0 0 0 1 0\n", index, camera.fx, camera.cx,
                 index == 0 ? 0.0 : -camera.fx * rig.baseline_m, camera.fy, camera.cy);
  }
  return absl::OkStatus();
}

absl::Status DatasetWriter::WriteDescription(const TownDrive& drive) const {
  File file;
  SEMMAP_RETURN_IF_ERROR(Open("town.json", &file));
  const DriveConfig& config = drive.config();
  const nlohmann::json description = {{"seed", config.seed},
                                      {"traffic_seed", config.traffic_seed},
                                      {"route", config.route},
                                      {"route_length_m", drive.route().path.length()},
                                      {"vehicles", config.traffic.vehicles},
                                      {"pedestrians", config.traffic.pedestrians},
                                      {"weather", config.weather},
                                      {"stereo", config.stereo},
                                      {"baseline_m", config.rig.baseline_m},
                                      {"frames_per_second", config.rig.frames_per_second},
                                      {"depth_units_per_metre", 1000},
                                      {"device", drive.device()}};
  std::fprintf(file.get(), "%s\n", description.dump(2).c_str());
  return absl::OkStatus();
}

absl::Status DatasetWriter::WriteImages(const DriveFrame& frame) const {
  const auto path = [&](const char* kind) {
    return absl::StrFormat("%s/%s/%06d.png", folder_, kind, frame.index);
  };
  const auto colour = [this](const cv::Mat& rgb) {
    cv::Mat image = rgb;
    if (options_.grey) cv::cvtColor(rgb, image, cv::COLOR_RGB2GRAY);
    return image;
  };
  SEMMAP_RETURN_IF_ERROR(WritePng(path("image_0"), colour(frame.left.rgb)));
  if (!frame.right_rgb.empty()) SEMMAP_RETURN_IF_ERROR(WritePng(path("image_1"), colour(frame.right_rgb)));
  if (options_.mask) SEMMAP_RETURN_IF_ERROR(WritePng(path("class"), frame.left.mask));
  if (options_.depth) {
    cv::Mat millimetres;
    cv::Mat near = frame.left.depth.clone();
    near.setTo(0, near > 65.5F);
    near.convertTo(millimetres, CV_16U, 1000.0);
    SEMMAP_RETURN_IF_ERROR(WritePng(path("depth"), millimetres));
  }
  return absl::OkStatus();
}

void DatasetWriter::WriteTexts(const DriveFrame& frame) {
  if (first_index_ < 0) {
    first_index_ = frame.index;
    first_camera_from_town_ = frame.town_from_camera.Inverse();
  }
  std::fprintf(times_.get(), "%.9f\n", static_cast<double>(frame.timestamp_ns) * 1e-9);
  // Exactly the identity for the first frame, without the rounding of a product with its own inverse.
  PrintPose(poses_.get(),
            frame.index == first_index_ ? SE3() : first_camera_from_town_ * frame.town_from_camera);
  PrintPose(poses_town_.get(), frame.town_from_camera);
  const auto timestamp = static_cast<long long>(frame.timestamp_ns);
  std::fprintf(odometry_.get(), "%lld,%.6f,%.6f\n", timestamp, frame.wheel_speed, frame.true_speed);
  if (frame.gnss.has_value()) {
    std::fprintf(gnss_.get(), "%lld,%.9f,%.9f,%.3f,%.3f\n", timestamp, frame.gnss->latitude,
                 frame.gnss->longitude, frame.gnss->altitude, frame.gnss->deviation_m);
  }
}

absl::Status DatasetWriter::Write(const DriveFrame& frame) {
  SEMMAP_RETURN_IF_ERROR(WriteImages(frame));
  WriteTexts(frame);
  return absl::OkStatus();
}

absl::Status DatasetWriter::Finish() {
  for (File* file : {&times_, &poses_, &poses_town_, &odometry_, &gnss_}) {
    if (std::fflush(file->get()) != 0 || std::ferror(file->get()) != 0) {
      return absl::ResourceExhaustedError(absl::StrCat("cannot write all of ", folder_));
    }
    file->reset();
  }
  return absl::OkStatus();
}

}  // namespace semmap::town
