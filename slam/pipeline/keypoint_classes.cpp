#include "slam/pipeline/keypoint_classes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace semmap {
namespace {

constexpr auto kSky = static_cast<uint8_t>(SemanticClass::kSky);

// What is of another class at half the radius around a pixel, or at all of it.
std::optional<PixelClass> Beside(uint8_t semantic_class, ClassLookup class_at, const cv::Point2f& pixel,
                                 double radius) {
  constexpr int kDirections = 8;
  for (const double distance : {0.5 * radius, radius}) {
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2 * std::numbers::pi * i / kDirections;
      const PixelClass beside =
          class_at(pixel.x + distance * std::cos(angle), pixel.y + distance * std::sin(angle));
      if (beside.semantic_class != semantic_class) return beside;
    }
  }
  return std::nullopt;
}

}  // namespace

KeypointClassRule::KeypointClassRule(const SemanticsConfig& config, const ScalePyramidInfo& scale_info)
    : min_confidence(static_cast<uint8_t>(std::lround(255 * config.min_confidence))),
      sky_rim_px(config.sky_rim_px),
      class_rim_px(config.class_rim_px),
      level_scale(scale_info.scales) {}

PixelClass LookUpMask(const cv::Mat& classes, const cv::Mat& confidence, double x, double y) {
  const cv::Point pixel(std::clamp(static_cast<int>(std::floor(x + 0.5)), 0, classes.cols - 1),
                        std::clamp(static_cast<int>(std::floor(y + 0.5)), 0, classes.rows - 1));
  return {classes.at<uint8_t>(pixel), confidence.empty() ? uint8_t{255} : confidence.at<uint8_t>(pixel)};
}

void ClassifyKeypoints(const KeypointClassRule& rule, const std::vector<cv::Point2f>& pixels,
                       ClassLookup class_at, std::vector<Keypoint>* keypoints) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    Keypoint& keypoint = (*keypoints)[i];
    PixelClass found = class_at(pixels[i].x, pixels[i].y);
    const double scale = rule.level_scale[keypoint.octave];
    if (rule.sky_rim_px > 0 && found.semantic_class == kSky)
      found = Beside(kSky, class_at, pixels[i], rule.sky_rim_px * scale).value_or(found);
    if (found.confidence < rule.min_confidence) continue;
    if (rule.class_rim_px > 0) {
      const auto beside = Beside(found.semantic_class, class_at, pixels[i], rule.class_rim_px * scale);
      if (beside) keypoint.class_beside = beside->semantic_class;
    }
    keypoint.semantic_class = found.semantic_class;
    keypoint.class_confidence = found.confidence;
  }
}

}  // namespace semmap
