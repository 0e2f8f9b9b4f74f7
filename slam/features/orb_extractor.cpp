#include "slam/features/orb_extractor.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "slam/common/config_reader.h"
#include "slam/features/corner_spread.h"
#include "slam/features/fast_detector.h"
#include "slam/features/patch_orientation.h"
#include "slam/features/steered_brief.h"

namespace semmap {
namespace {

// Room that the orientation disc and the rotated pattern need around a corner.
constexpr int kMargin = std::max(kOrientationRadius, kBriefRadius) + 1;
// Rows of every level lie equally far apart, so that one table of pattern offsets serves all; the slack lets
// vector loads run past the last pixel.
constexpr int kRowAlignment = 64;
constexpr int kSlack = FastDetector::kOverread;
// A level smaller than this has no room for corners worth having.
constexpr int kMinLevelSide = 2 * kMargin + 8;
constexpr int kMinImageSide = 64;
constexpr int kMaxImageSide = 16384;
constexpr double kBlurSigma = 2.0;
constexpr int kBlurSide = 7;

int AlignUp(int value, int alignment) { return (value + alignment - 1) / alignment * alignment; }

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
  explicit State(const OrbConfig& orb_config)
      : config(orb_config),
        scale_info(orb_config.levels, orb_config.scale_factor),
        shares(ShareOfLevels(orb_config.features, orb_config.levels, orb_config.scale_factor)) {}

  void Resize(const cv::Size& size);
  void BuildPyramid(const cv::Mat& grey);
  void DetectLevel(int level, int wanted);
  void DescribeLevel(int level, FrameFeatures* features);

  OrbConfig config;
  ScalePyramidInfo scale_info;
  std::vector<int> shares;
  std::vector<cv::Mat> pyramid;
  std::vector<cv::Mat> buffers;  // that the levels are windows of
  cv::Mat blurred;
  std::vector<std::vector<Corner>> level_corners;
  std::vector<Corner> corners;
  FastDetector detector;
  CornerSpread spread;
  std::unique_ptr<SteeredBrief> brief;
};

// Lays out the buffers for images of another size.
void OrbExtractor::State::Resize(const cv::Size& size) {
  if (!pyramid.empty() && pyramid[0].size() == size) return;
  const int step = AlignUp(size.width, kRowAlignment) + kSlack;
  pyramid.assign(config.levels, cv::Mat());
  buffers.assign(config.levels, cv::Mat());
  level_corners.resize(config.levels);
  for (int level = 0; level < config.levels; ++level) {
    const double scale = std::pow(config.scale_factor, level);
    const int width = std::max(1, static_cast<int>(std::lround(size.width / scale)));
    const int height = std::max(1, static_cast<int>(std::lround(size.height / scale)));
    buffers[level] = cv::Mat::zeros(height + 1, step, CV_8UC1);
    pyramid[level] = buffers[level](cv::Rect(0, 0, width, height));
  }
  blurred = cv::Mat::zeros(size.height + 1, step, CV_8UC1);
  brief = std::make_unique<SteeredBrief>(OrbPattern(), step);
}

void OrbExtractor::State::BuildPyramid(const cv::Mat& grey) {
  grey.copyTo(pyramid[0]);
  for (int level = 1; level < config.levels; ++level) {
    cv::resize(pyramid[level - 1], pyramid[level], pyramid[level].size(), 0, 0, cv::INTER_LINEAR);
  }
}

void OrbExtractor::State::DetectLevel(int level, int wanted) {
  const cv::Mat& image = pyramid[level];
  level_corners[level].clear();
  if (image.cols < kMinLevelSide || image.rows < kMinLevelSide) return;
  const CornerSpread::Region region{kMargin, kMargin, image.cols - kMargin, image.rows - kMargin};
  detector.Detect(image, {kMargin, kMargin, image.cols - 2 * kMargin, image.rows - 2 * kMargin},
                  config.min_fast_threshold, &corners);
  spread.Select(corners, region, wanted, config.fast_threshold, &level_corners[level]);
}

void OrbExtractor::State::DescribeLevel(int level, FrameFeatures* features) {
  if (level_corners[level].empty()) return;
  const cv::Mat& image = pyramid[level];
  cv::Mat smooth = blurred(cv::Rect(cv::Point(0, 0), image.size()));
  cv::GaussianBlur(image, smooth, {kBlurSide, kBlurSide}, kBlurSigma, kBlurSigma,
                   cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
  // Resizing maps the image's outer edges onto each other, not the centres of the first pixels.
  const float scale_x = static_cast<float>(pyramid[0].cols) / static_cast<float>(image.cols);
  const float scale_y = static_cast<float>(pyramid[0].rows) / static_cast<float>(image.rows);
  for (const Corner& corner : level_corners[level]) {
    Keypoint keypoint;
    keypoint.x = (static_cast<float>(corner.x) + 0.5F) * scale_x - 0.5F;
    keypoint.y = (static_cast<float>(corner.y) + 0.5F) * scale_y - 0.5F;
    keypoint.octave = static_cast<uint8_t>(level);
    keypoint.angle =
        IntensityCentroidAngle(image.ptr(corner.y, corner.x), static_cast<ptrdiff_t>(image.step[0]));
    features->keypoints.push_back(keypoint);
    brief->Compute(smooth.ptr(corner.y, corner.x), keypoint.angle, &features->descriptors.emplace_back());
  }
}

OrbExtractor::OrbExtractor(const OrbConfig& config) : state_(std::make_unique<State>(config)) {}
OrbExtractor::~OrbExtractor() = default;
OrbExtractor::OrbExtractor(OrbExtractor&&) noexcept = default;
OrbExtractor& OrbExtractor::operator=(OrbExtractor&&) noexcept = default;

void OrbExtractor::Extract(const cv::Mat& grey, FrameFeatures* features) {
  features->keypoints.clear();
  features->descriptors.clear();
  if (grey.type() != CV_8UC1 || std::min(grey.cols, grey.rows) < kMinImageSide ||
      std::max(grey.cols, grey.rows) > kMaxImageSide) {
    return;
  }
  state_->Resize(grey.size());
  state_->BuildPyramid(grey);
  // What a coarse level cannot give, the next finer one may.
  int missing = 0;
  for (int level = state_->config.levels - 1; level >= 0; --level) {
    const int wanted = state_->shares[level] + missing;
    state_->DetectLevel(level, wanted);
    missing = wanted - static_cast<int>(state_->level_corners[level].size());
  }
  for (int level = 0; level < state_->config.levels; ++level) state_->DescribeLevel(level, features);
}

const std::vector<cv::Mat>& OrbExtractor::pyramid() const { return state_->pyramid; }
const ScalePyramidInfo& OrbExtractor::scale_info() const { return state_->scale_info; }
const OrbConfig& OrbExtractor::config() const { return state_->config; }

}  // namespace semmap
