#include "slam/semantics/segmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Core>
#include <opencv2/imgproc.hpp>

#include "slam/semantics/segmentation_model.h"

namespace semmap {
namespace {

// A place on one axis of the grid: the cell before it, and how far it is to the next one.
struct GridPosition {
  int cell;
  int next;
  float share;
};

// Cells and pixels cover the same length: the centre of the first cell lies half a cell inside.
GridPosition ToGrid(float pixel, int pixels, int cells) {
  const float scale = static_cast<float>(cells) / static_cast<float>(pixels);
  const float position = std::clamp((pixel + 0.5F) * scale - 0.5F, 0.0F, static_cast<float>(cells - 1));
  const int cell = static_cast<int>(position);
  return {cell, std::min(cell + 1, cells - 1), position - static_cast<float>(cell)};
}

uint8_t ToByte(float probability) { return static_cast<uint8_t>(std::lround(255.0F * probability)); }

}  // namespace

Segmentation::Segmentation(cv::Size image, cv::Size grid, std::vector<float> scores,
                           std::shared_ptr<const std::vector<uint8_t>> class_of_channel)
    : image_(image), grid_(grid), scores_(std::move(scores)), class_of_channel_(std::move(class_of_channel)) {
  CV_Assert(scores_.size() == class_of_channel_->size() * static_cast<size_t>(grid.area()));
}

// Overwrites the scores.
PixelClass Segmentation::Decide(float* scores) const {
  const std::vector<uint8_t>& classes = *class_of_channel_;
  const float* best = std::max_element(scores, scores + classes.size());
  const uint8_t winner = classes[static_cast<size_t>(best - scores)];
  const float highest = *best;
  float all = 0;
  float of_winner = 0;
  for (size_t channel = 0; channel < classes.size(); ++channel) {
    const float weight = std::exp(scores[channel] - highest);
    all += weight;
    if (classes[channel] == winner) of_winner += weight;
  }
  return {winner, ToByte(of_winner / all)};
}

PixelClass Segmentation::At(float x, float y) const {
  const GridPosition column = ToGrid(x, image_.width, grid_.width);
  const GridPosition row = ToGrid(y, image_.height, grid_.height);
  const auto plane_size = static_cast<size_t>(grid_.area());
  const auto upper = static_cast<size_t>(row.cell * grid_.width);
  const auto lower = static_cast<size_t>(row.next * grid_.width);
  std::array<float, kMaxSegmentationChannels> scores;
  for (size_t channel = 0; channel < class_of_channel_->size(); ++channel) {
    const float* plane = scores_.data() + channel * plane_size;
    const auto along = [&](size_t start) {
      return plane[start + column.cell] * (1 - column.share) + plane[start + column.next] * column.share;
    };
    scores[channel] = along(upper) * (1 - row.share) + along(lower) * row.share;
  }
  return Decide(scores.data());
}

cv::Mat Segmentation::PlaneOf(size_t channel) const {
  // OpenCV has no matrix of constants; resize only reads it.
  auto* plane = const_cast<float*>(scores_.data()) + channel * static_cast<size_t>(grid_.area());
  cv::Mat enlarged;
  cv::resize(cv::Mat(grid_, CV_32FC1, plane), enlarged, image_, 0, 0, cv::INTER_LINEAR);
  return enlarged;
}

void Segmentation::ToMasks(cv::Mat* classes, cv::Mat* confidences) const {
  std::vector<cv::Mat> planes;
  for (size_t channel = 0; channel < class_of_channel_->size(); ++channel) planes.push_back(PlaneOf(channel));
  classes->create(image_, CV_8UC1);
  if (confidences != nullptr) confidences->create(image_, CV_8UC1);
  std::vector<const float*> scores(planes.size());
  for (int y = 0; y < image_.height; ++y) {
    std::transform(planes.begin(), planes.end(), scores.begin(),
                   [y](const cv::Mat& plane) { return plane.ptr<float>(y); });
    DecideRow(scores, classes->ptr<uint8_t>(y),
              confidences == nullptr ? nullptr : confidences->ptr<uint8_t>(y));
  }
}

// As Decide for each pixel of a row, channel by channel: with exponentials of many pixels at once, whole
// masks take a fifth of the time.
void Segmentation::DecideRow(const std::vector<const float*>& scores, uint8_t* winners,
                             uint8_t* confidences) const {
  using Row = Eigen::ArrayXf;
  const std::vector<uint8_t>& classes = *class_of_channel_;
  const Eigen::Index width = image_.width;
  Row best = Row::Constant(width, -std::numeric_limits<float>::infinity());
  for (size_t channel = 0; channel < classes.size(); ++channel) {
    for (Eigen::Index x = 0; x < width; ++x) {
      const bool is_better = scores[channel][x] > best[x];
      best[x] = is_better ? scores[channel][x] : best[x];
      winners[x] = is_better ? classes[channel] : winners[x];
    }
  }
  if (confidences == nullptr) return;
  Row all = Row::Zero(width);
  Row of_winner = Row::Zero(width);
  for (size_t channel = 0; channel < classes.size(); ++channel) {
    const Row weight = (Eigen::Map<const Row>(scores[channel], width) - best).exp();
    all += weight;
    for (Eigen::Index x = 0; x < width; ++x) of_winner[x] += winners[x] == classes[channel] ? weight[x] : 0;
  }
  for (Eigen::Index x = 0; x < width; ++x) confidences[x] = ToByte(of_winner[x] / all[x]);
}

}  // namespace semmap
