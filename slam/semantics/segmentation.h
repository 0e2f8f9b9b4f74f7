#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slam/semantics/taxonomy.h"

namespace semmap {

// What a pixel shows: an id of SemanticClass (kUnknownClass: none of them), and how sure that is, 255 meaning
// certain.
struct PixelClass {
  uint8_t semantic_class = kUnknownClass;
  uint8_t confidence = 0;
};

// What a network says about one image: a score (logit) for each of its channels at each cell of a grid that
// is spread evenly over the image. Between the centres of cells scores are interpolated bilinearly; the class
// is that of the channel with the highest score, its confidence the softmax probability of all channels of
// that class. Immutable and thread-safe.
class Segmentation {
 public:
  // `scores` holds class_of_channel.size() planes of grid.area() values, row after row.
  Segmentation(cv::Size image, cv::Size grid, std::vector<float> scores,
               std::shared_ptr<const std::vector<uint8_t>> class_of_channel);

  // At a pixel of the image, whose centre has whole coordinates; outside, that of the nearest cell. Costs a
  // few hundred nanoseconds: a frame asks for its keypoints, not for all its pixels.
  PixelClass At(float x, float y) const;

  // Every pixel of the image: ids of SemanticClass, and unless null the confidences; both CV_8UC1.
  void ToMasks(cv::Mat* classes, cv::Mat* confidences) const;

  cv::Size image() const { return image_; }
  cv::Size grid() const { return grid_; }

 private:
  PixelClass Decide(float* scores) const;
  void DecideRow(const std::vector<const float*>& scores, uint8_t* winners, uint8_t* confidences) const;
  cv::Mat PlaneOf(size_t channel) const;

  cv::Size image_;
  cv::Size grid_;
  std::vector<float> scores_;
  std::shared_ptr<const std::vector<uint8_t>> class_of_channel_;
};

}  // namespace semmap
