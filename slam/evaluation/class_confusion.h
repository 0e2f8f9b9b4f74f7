#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "slam/semantics/taxonomy.h"

namespace semmap {

// What a class of ours counts as where labels are coarser than SemanticClass.
using ClassMerge = std::array<uint8_t, 256>;

// "none", "carla" (0.8: lights are signs, grass is vegetation, street furniture is Other) or "camvid11" (lane
// markings are Road, walls and bridges Building, lights TrafficSign, grass Vegetation). INVALID_ARGUMENT for
// other names.
absl::StatusOr<ClassMerge> FindClassMerge(std::string_view name);

// Counts pixels by labelled and predicted class (the paper's Table 1). Pixels labelled Unlabeled or unknown
// are left out.
class ClassConfusion {
 public:
  explicit ClassConfusion(const ClassMerge& merge) : merge_(merge) {}

  // Both CV_8UC1 and equally large. INVALID_ARGUMENT otherwise, and for labels that are no class.
  absl::Status Add(const cv::Mat& label, const cv::Mat& prediction);

  // Of a class that the labels have; nothing for others.
  std::optional<double> IntersectionOverUnion(uint8_t id) const;
  // Share of the class's pixels that were recognized.
  std::optional<double> Accuracy(uint8_t id) const;
  // Over the classes that the labels have; 0 without any.
  double MeanIoU() const;
  int ClassesPresent() const;
  double PixelAccuracy() const;
  int64_t pixels() const { return pixels_; }

 private:
  ClassMerge merge_;
  int64_t pixels_ = 0;
  std::array<int64_t, kSemanticClassCount> labelled_ = {};
  std::array<int64_t, 256> predicted_ = {};
  std::array<int64_t, kSemanticClassCount> hits_ = {};
};

}  // namespace semmap
