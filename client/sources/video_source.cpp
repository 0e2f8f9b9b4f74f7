#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "absl/strings/str_cat.h"
#include "client/sources/camera_file.h"
#include "client/sources/file_list.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

constexpr double kMillisecond = 1e-3;

class VideoSource : public FrameSource {
 public:
  VideoSource(std::string path, const CameraRig& rig, const cv::VideoCapture& capture)
      : path_(std::move(path)), rig_(rig), capture_(capture) {}

  const CameraRig& rig() const override { return rig_; }
  std::optional<size_t> frame_count() const override {
    const double count = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    if (!(count > 0) || count > static_cast<double>(kMaxFrames)) return std::nullopt;
    return static_cast<size_t>(count);
  }
  const std::optional<Trajectory>& ground_truth() const override { return ground_truth_; }

  absl::StatusOr<std::optional<SourceFrame>> Next() override {
    try {
      return ReadNext();
    } catch (const cv::Exception& error) {
      return absl::InternalError(absl::StrCat(path_, ": ", error.what()));
    }
  }

 private:
  absl::StatusOr<std::optional<SourceFrame>> ReadNext() {
    cv::Mat picture;
    const double position_ms = capture_.get(cv::CAP_PROP_POS_MSEC);
    if (!capture_.read(picture) || picture.empty()) return std::nullopt;
    if (picture.cols != rig_.camera.width || picture.rows != rig_.camera.height) {
      return absl::InvalidArgumentError(absl::StrCat(path_, ": frames are ", picture.cols, "x", picture.rows,
                                                     ", the camera file says ", rig_.camera.width, "x",
                                                     rig_.camera.height));
    }
    SourceFrame frame;
    frame.sequence = next_;
    frame.timestamp = TimeOf(position_ms);
    if (picture.channels() == 1) {
      frame.image.pixels = picture;
    } else {
      cv::cvtColor(picture, frame.image.pixels, cv::COLOR_BGR2GRAY);
    }
    ++next_;
    return frame;
  }

  // The container's time where it has one that grows, else by the frame rate.
  TimestampNs TimeOf(double position_ms) {
    const TimestampNs told = FromSeconds(position_ms * kMillisecond);
    const bool grows = next_ == 0 || told > last_;
    last_ = grows ? told : last_ + FromSeconds(1.0 / rig_.frames_per_second);
    return last_;
  }

  std::string path_;
  CameraRig rig_;
  cv::VideoCapture capture_;
  std::optional<Trajectory> ground_truth_;
  uint64_t next_ = 0;
  TimestampNs last_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenVideoSource(const std::string& file,
                                                             const SourceOptions& options) {
  if (options.sensor != SensorType::kMono)
    return absl::InvalidArgumentError("a video has one camera: --sensor mono");
  if (options.camera_file.empty())
    return absl::InvalidArgumentError("a video needs a camera file: --camera FILE");
  if (!FileExists(file)) return absl::NotFoundError(absl::StrCat(file, ": no such file"));
  SEMMAP_ASSIGN_OR_RETURN(CameraRig rig, ReadCameraFile(options.camera_file, options.sensor));
  try {
    cv::VideoCapture capture(file);
    if (!capture.isOpened())
      return absl::InvalidArgumentError(absl::StrCat(file, ": no video that can be played"));
    const double rate = capture.get(cv::CAP_PROP_FPS);
    if (rate >= 0.01 && rate <= 1000) rig.frames_per_second = rate;
    return std::make_unique<VideoSource>(file, rig, capture);
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(file, ": ", error.what()));
  }
}

}  // namespace semmap::client
