#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "client/image.h"
#include "semmap/v1/camera.pb.h"
#include "semmap/v1/frame.pb.h"

namespace semmap {

// Frames of a KITTI folder as a vehicle sends them: the files as they are.
class KittiFrames {
 public:
  // A sequence of the shared data; see `available`.
  explicit KittiFrames(const std::string& name) {
    const char* shared = std::getenv("SEMMAP_SHARED");
    const std::filesystem::path root =
        shared != nullptr ? shared : std::filesystem::path(SEMMAP_SOURCE_DIR).parent_path() / "shared";
    folder_ = root / "data" / "sequences" / name;
  }

  bool available() const { return std::filesystem::exists(folder_ / "calib.txt"); }
  std::string folder() const { return folder_.string(); }

  v1::CameraRig Rig(v1::SensorType sensor) const {
    const std::vector<double> left = Projection("P0:");
    const std::vector<double> right = Projection("P1:");
    const cv::Mat first = cv::imread(ImagePath("image_0", 0), cv::IMREAD_UNCHANGED);
    v1::CameraRig rig;
    rig.set_sensor(sensor);
    v1::CameraIntrinsics* camera = rig.mutable_camera();
    camera->set_width(first.cols);
    camera->set_height(first.rows);
    camera->set_fx(left[0]);
    camera->set_fy(left[5]);
    camera->set_cx(left[2]);
    camera->set_cy(left[6]);
    camera->set_distortion_model(v1::DISTORTION_MODEL_NONE);
    if (sensor == v1::SENSOR_TYPE_STEREO) rig.set_baseline_m(-right[3] / right[0]);
    rig.set_frames_per_second(10);
    return rig;
  }

  // index counts from 0; sequence numbers from 1.
  v1::Frame Frame(int index, v1::SensorType sensor) const {
    v1::Frame frame;
    frame.set_sequence(static_cast<uint64_t>(index) + 1);
    frame.set_timestamp_ns(int64_t{index} * 100'000'000);
    *frame.mutable_image() = client::FileImage(Bytes("image_0", index)).value();
    if (sensor == v1::SENSOR_TYPE_STEREO) {
      *frame.mutable_right() = client::FileImage(Bytes("image_1", index)).value();
    }
    return frame;
  }

 private:
  std::string ImagePath(const char* camera, int index) const {
    for (const char* extension : {"png", "jpg"}) {
      char name[32];
      snprintf(name, sizeof(name), "%06d.%s", index, extension);
      const std::filesystem::path path = folder_ / camera / name;
      if (std::filesystem::exists(path)) return path.string();
    }
    return {};
  }
  std::string Bytes(const char* camera, int index) const {
    std::ifstream file(ImagePath(camera, index), std::ios::binary);
    std::stringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
  }
  std::vector<double> Projection(const std::string& label) const {
    std::ifstream file(folder_ / "calib.txt");
    std::vector<double> values(12);
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string first;
      if (!(words >> first) || first != label) continue;
      for (double& value : values) words >> value;
    }
    return values;
  }

  std::filesystem::path folder_;
};

}  // namespace semmap
