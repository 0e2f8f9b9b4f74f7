#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "slam/common/fwd.h"

namespace semmap {

constexpr size_t kMaxSegmentationChannels = 256;

// Describes a network that somebody trained: a YAML file beside the TorchScript file.
//
//   file: street.pt            # relative to the YAML file
//   input_width: 512           # what the network was trained to see of a 4:3 image
//   input_height: 384
//   mean: [0.485, 0.456, 0.406]
//   std: [0.229, 0.224, 0.225]
//   classes: carla23           # or for each output channel a CARLA id, 255 for none
//
// The network's forward() takes float32 N x 3 x H x W (red, green, blue in 0..1, less the mean, divided by
// std; H and W multiples of 32) and returns float32 scores N x C x H/k x W/k, k being 1, 2 or 4, before any
// softmax.
struct SegmentationModel {
  std::string file;  // path
  int input_width = 512;
  int input_height = 384;
  std::array<float, 3> mean = {0, 0, 0};
  std::array<float, 3> std = {1, 1, 1};
  std::shared_ptr<const std::vector<uint8_t>> class_of_channel;

  // INVALID_ARGUMENT or NOT_FOUND name the file and what is wrong with it. Does not look at the network.
  static absl::StatusOr<SegmentationModel> FromFile(const std::string& path);
  void Read(ConfigReader& reader);

  // What the network gets to see of an image: about input_width x input_height pixels in the image's own
  // proportions, in multiples of 32.
  cv::Size NetworkSize(cv::Size image) const;
};

// The model that ships with semmap.
std::string DefaultSegmentationModelPath();

// An image (CV_8UC3 BGR, or CV_8UC1 which counts as three equal channels) resized to the network's size and
// normalized, as three planes of size.area() values each. Averages when it shrinks, interpolates bilinearly
// when it grows.
void FillNetworkInput(const SegmentationModel& model, const cv::Mat& image, cv::Size size, float* planes);

}  // namespace semmap
