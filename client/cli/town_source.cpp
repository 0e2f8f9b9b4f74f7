#include "client/cli/town_source.h"

#include <opencv2/imgproc.hpp>

#include "client/image.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

CameraRig RigOf(const town::DriveConfig& config) {
  CameraRig rig;
  rig.sensor = config.stereo ? SensorType::kStereo : SensorType::kMono;
  rig.camera = config.rig.Intrinsics();
  if (config.stereo) rig.baseline_m = config.rig.baseline_m;
  rig.frames_per_second = config.rig.frames_per_second;
  rig.body_from_camera = config.rig.VehicleFromCamera();
  return rig;
}

}  // namespace

absl::StatusOr<std::unique_ptr<TownSource>> TownSource::Create(const town::DriveConfig& config,
                                                               const TownSourceOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<town::TownDrive> drive, town::TownDrive::Create(config));
  return std::unique_ptr<TownSource>(new TownSource(std::move(drive), options));
}

TownSource::TownSource(std::unique_ptr<town::TownDrive> drive, const TownSourceOptions& options)
    : drive_(std::move(drive)), options_(options), rig_(RigOf(drive_->config())), truth_(Trajectory()) {}

std::optional<size_t> TownSource::frame_count() const {
  const int limit = drive_->config().max_frames;
  return limit > 0 ? std::optional<size_t>(static_cast<size_t>(limit)) : std::nullopt;
}

absl::StatusOr<SourceImage> TownSource::Encode(const cv::Mat& rgb) const {
  SourceImage image;
  // Into pixels of their own: the drive draws the next frame into the same ones.
  cv::cvtColor(rgb, image.pixels, options_.grey ? cv::COLOR_RGB2GRAY : cv::COLOR_RGB2BGR);
  if (options_.jpeg_quality == 0) return image;
  SEMMAP_ASSIGN_OR_RETURN(v1::Image file, JpegImage(image.pixels, options_.jpeg_quality));
  image.encoding = ImageEncoding::kJpeg;
  image.encoded = std::move(*file.mutable_data());
  image.pixels.release();
  return image;
}

absl::StatusOr<std::optional<SourceFrame>> TownSource::Next() {
  SEMMAP_ASSIGN_OR_RETURN(const bool more, drive_->Next(&frame_));
  if (!more) return std::nullopt;
  SourceFrame sent;
  sent.sequence = truth_->size();
  sent.timestamp = frame_.timestamp_ns;
  SEMMAP_ASSIGN_OR_RETURN(sent.image, Encode(frame_.left.rgb));
  if (!frame_.right_rgb.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(sent.right, Encode(frame_.right_rgb));
  }
  if (options_.class_mask) sent.class_mask.pixels = frame_.left.mask.clone();
  sent.wheel_speed_m_s = frame_.wheel_speed;
  if (const auto& fix = frame_.gnss)
    sent.gnss = {fix->latitude, fix->longitude, fix->altitude, fix->deviation_m};
  if (truth_->empty()) map_from_town_ = frame_.town_from_camera.Inverse();
  truth_->poses.push_back({frame_.timestamp_ns, map_from_town_ * frame_.town_from_camera});
  return sent;
}

}  // namespace semmap::client
