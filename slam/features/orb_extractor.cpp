#include "slam/features/orb_extractor.h"

#include <algorithm>
#include <cmath>

#include "slam/common/config_reader.h"
#include "slam/features/corner_spread.h"
#include "slam/features/fast_detector.h"
#include "slam/features/image_pyramid.h"
#include "slam/features/padded_image.h"
#include "slam/features/patch_orientation.h"
#include "slam/features/smoothing.h"
#include "slam/features/steered_brief.h"

namespace semmap {
namespace {

// Room that the orientation disc and the rotated pattern need around a corner.
constexpr int kMargin = std::max(kOrientationRadius, kBriefRadius) + 1;
// A level smaller than this has no room for corners worth having.
constexpr int kMinLevelSide = 2 * kMargin + 8;
constexpr int kMinImageSide = 64;
constexpr int kMaxImageSide = 16384;

// Shares `total` between levels in proportion to factor^-level.
std::vector<int> ShareOfLevels(int total, int levels, double factor) {
  double sum = 0;
  for (int level = 0; level < levels; ++level) sum += std::pow(factor, -level);
  std::vector<int> shares(levels);
  int given = 0;
  for (int level = 1; level < levels; ++level) {
    shares[level] = static_cast<int>(std::lround(total * std::pow(factor, -level) / sum));
    given += shares[level];
  }
  shares[0] = std::max(0, total - given);
  return shares;
}

}  // namespace

void OrbConfig::Read(ConfigReader& reader) {
  reader.Number("features", &features, 100, 10000);
  reader.Number("levels", &levels, 1, 12);
  reader.Number("scale_factor", &scale_factor, 1.05, 2.0);
  reader.Number("fast_threshold", &fast_threshold, 3, 100);
  reader.Number("min_fast_threshold", &min_fast_threshold, 1, 100);
  if (min_fast_threshold > fast_threshold) {
    reader.Complain("min_fast_threshold", "must not be above fast_threshold");
  }
}

struct OrbExtractor::State {
  State(const OrbConfig& orb_config, const BriefPattern& pattern)
      : config(orb_config),
        scale_info(orb_config.levels, orb_config.scale_factor),
        shares(ShareOfLevels(orb_config.features, orb_config.levels, orb_config.scale_factor)),
        pyramid(orb_config.levels, orb_config.scale_factor),
        brief(pattern) {}

  int ExtractLevel(int level, int wanted, FrameFeatures* features);
  void Describe(int level, FrameFeatures* features);

  OrbConfig config;
  ScalePyramidInfo scale_info;
  std::vector<int> shares;
  ImagePyramid pyramid;
  Smoother smoother;
  cv::Mat smoothed;  // one level at a time
  std::vector<Corner> selected;
  FastDetector detector;
  CornerSpread spread;
  SteeredBrief brief;
};

// Appends at most `wanted` features of a level; returns how many.
int OrbExtractor::State::ExtractLevel(int level, int wanted, FrameFeatures* features) {
  const cv::Mat& image = pyramid.levels()[level];
  if (image.cols < kMinLevelSide || image.rows < kMinLevelSide) return 0;
  const CornerSpread::Region region{kMargin, kMargin, image.cols - kMargin, image.rows - kMargin};
  const auto corners =
      detector.Detect(image, {kMargin, kMargin, image.cols - 2 * kMargin, image.rows - 2 * kMargin},
                      config.min_fast_threshold);
  spread.Select(corners, region, wanted, config.fast_threshold, &selected);
  if (!selected.empty()) Describe(level, features);
  return static_cast<int>(selected.size());
}

void OrbExtractor::State::Describe(int level, FrameFeatures* features) {
  const cv::Mat& image = pyramid.levels()[level];
  cv::Mat smooth = smoothed(cv::Rect({0, 0}, image.size()));
  smoother.Smooth(image, &smooth);
  const auto step = static_cast<ptrdiff_t>(image.step[0]);
  const auto smooth_step = static_cast<ptrdiff_t>(smooth.step[0]);
  // Resizing maps the image's outer edges onto each other, not the centres of the first pixels.
  const float scale_x = static_cast<float>(pyramid.levels()[0].cols) / static_cast<float>(image.cols);
  const float scale_y = static_cast<float>(pyramid.levels()[0].rows) / static_cast<float>(image.rows);
  for (const Corner& corner : selected) {
    const cv::Point2f offset = detector.SubPixelOffset(corner);
    Keypoint keypoint;
    keypoint.x = (static_cast<float>(corner.x) + offset.x + 0.5F) * scale_x - 0.5F;
    keypoint.y = (static_cast<float>(corner.y) + offset.y + 0.5F) * scale_y - 0.5F;
    keypoint.octave = static_cast<uint8_t>(level);
    keypoint.angle = IntensityCentroidAngle(image.ptr(corner.y, corner.x), step);
    features->keypoints.push_back(keypoint);
    brief.Compute(smooth.ptr(corner.y, corner.x), smooth_step, keypoint.angle,
                  &features->descriptors.emplace_back());
  }
}

OrbExtractor::OrbExtractor(const OrbConfig& config) : OrbExtractor(config, OrbPattern()) {}
OrbExtractor::OrbExtractor(const OrbConfig& config, const BriefPattern& pattern)
    : state_(std::make_unique<State>(config, pattern)) {}
OrbExtractor::~OrbExtractor() = default;
OrbExtractor::OrbExtractor(OrbExtractor&&) noexcept = default;
OrbExtractor& OrbExtractor::operator=(OrbExtractor&&) noexcept = default;

void OrbExtractor::Extract(const cv::Mat& grey, FrameFeatures* features) {
  features->keypoints.clear();
  features->descriptors.clear();
  if (grey.type() != CV_8UC1 || std::min(grey.cols, grey.rows) < kMinImageSide ||
      std::max(grey.cols, grey.rows) > kMaxImageSide) {
    state_->pyramid.Clear();
    return;
  }
  state_->pyramid.Build(grey);
  if (state_->smoothed.size() != grey.size()) state_->smoothed = MakePaddedImage(grey.size());
  // What a coarse level cannot give, the next finer one may.
  int missing = 0;
  for (int level = state_->config.levels - 1; level >= 0; --level) {
    const int wanted = state_->shares[level] + missing;
    missing = wanted - state_->ExtractLevel(level, wanted, features);
  }
}

const std::vector<cv::Mat>& OrbExtractor::pyramid() const { return state_->pyramid.levels(); }
const ScalePyramidInfo& OrbExtractor::scale_info() const { return state_->scale_info; }
const OrbConfig& OrbExtractor::config() const { return state_->config; }

}  // namespace semmap
