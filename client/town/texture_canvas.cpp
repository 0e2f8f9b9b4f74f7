#include "client/town/texture_canvas.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace semmap::town {
namespace {

cv::Mat White(cv::Size size, Random* random) {
  cv::Mat noise(size, CV_32F);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) noise.at<float>(y, x) = static_cast<float>(random->Uniform(-1, 1));
  }
  return noise;
}

void Normalize(cv::Mat* noise) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(*noise, mean, deviation);
  *noise = (*noise - mean[0]) / std::max(1e-6, deviation[0]);
}

cv::Mat Octave(cv::Size size, cv::Size cells, Random* random) {
  const cv::Mat white = White(cells, random);
  constexpr int kRim = 3;
  cv::Mat wrapped;
  cv::copyMakeBorder(white, wrapped, kRim, kRim, kRim, kRim, cv::BORDER_WRAP);
  const double scale_x = static_cast<double>(size.width) / cells.width;
  const double scale_y = static_cast<double>(size.height) / cells.height;
  const cv::Size grown(static_cast<int>(std::lround(scale_x * (cells.width + 2 * kRim))),
                       static_cast<int>(std::lround(scale_y * (cells.height + 2 * kRim))));
  cv::Mat fine;
  cv::resize(wrapped, fine, grown, 0, 0, cv::INTER_CUBIC);
  return fine(cv::Rect(static_cast<int>(std::lround(scale_x * kRim)),
                       static_cast<int>(std::lround(scale_y * kRim)), size.width, size.height))
      .clone();
}

}  // namespace

cv::Mat Noise(cv::Size size, cv::Size cells, int octaves, double gain, Random* random) {
  cv::Mat sum = cv::Mat::zeros(size, CV_32F);
  double amplitude = 1.0;
  for (int i = 0; i < octaves; ++i) {
    const cv::Size clipped(std::min(cells.width, size.width), std::min(cells.height, size.height));
    sum += amplitude * Octave(size, clipped, random);
    cells *= 2;
    amplitude *= gain;
  }
  Normalize(&sum);
  return sum;
}

cv::Mat Speckle(cv::Size size, double sigma, Random* random) {
  cv::Mat noise = White(size, random);
  if (sigma > 0) {
    constexpr int kRim = 16;
    cv::copyMakeBorder(noise, noise, kRim, kRim, kRim, kRim, cv::BORDER_WRAP);
    cv::GaussianBlur(noise, noise, cv::Size(), sigma);
    noise = noise(cv::Rect(kRim, kRim, size.width, size.height)).clone();
  }
  Normalize(&noise);
  return noise;
}

cv::Mat Filled(cv::Size size, const cv::Scalar& rgb) { return {size, CV_32FC3, rgb}; }

void Modulate(cv::Mat* canvas, const cv::Mat& noise, double strength) {
  cv::Mat factor = 1.0 + strength * noise;
  cv::Mat wide;
  cv::merge(std::vector<cv::Mat>(3, factor), wide);
  *canvas = canvas->mul(wide);
}

void Blend(cv::Mat* canvas, const cv::Mat& mask, const cv::Scalar& rgb) {
  cv::Mat wide;
  cv::merge(std::vector<cv::Mat>(3, mask), wide);
  const cv::Mat colour(canvas->size(), CV_32FC3, rgb);
  *canvas = *canvas + wide.mul(colour - *canvas);
}

cv::Mat SmoothMask(const cv::Mat& noise, double low, double high) {
  cv::Mat t = (noise - low) / (high - low);
  t = cv::min(cv::max(t, 0.0), 1.0);
  return t.mul(t).mul(3.0 - 2.0 * t);
}

namespace {

// Draws a line wherever it shows when the canvas repeats.
void WrappedLine(cv::Mat* canvas, cv::Point2d a, cv::Point2d b, const cv::Scalar& rgb, int thickness) {
  constexpr int kShift = 4;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      const cv::Point2d move(dx * canvas->cols, dy * canvas->rows);
      const cv::Point p((a + move) * (1 << kShift));
      const cv::Point q((b + move) * (1 << kShift));
      cv::line(*canvas, p, q, rgb, thickness, cv::LINE_AA, kShift);
    }
  }
}

}  // namespace

void DrawCracks(cv::Mat* canvas, int count, double length, const cv::Scalar& rgb, double thickness,
                Random* random) {
  for (int i = 0; i < count; ++i) {
    cv::Point2d at(random->Uniform(0, canvas->cols), random->Uniform(0, canvas->rows));
    double angle = random->Uniform(0, 2 * CV_PI);
    const int steps = static_cast<int>(length / 6);
    for (int step = 0; step < steps; ++step) {
      angle += random->Normal() * 0.45;
      const cv::Point2d next = at + cv::Point2d(std::cos(angle), std::sin(angle)) * 6.0;
      const int width = std::max(1, static_cast<int>(std::lround(thickness * random->Uniform(0.6, 1.2))));
      WrappedLine(canvas, at, next, rgb, width);
      at = next;
    }
  }
}

void DrawStreaks(cv::Mat* canvas, int count, double strength, Random* random) {
  cv::Mat mask = cv::Mat::zeros(canvas->size(), CV_32F);
  for (int i = 0; i < count; ++i) {
    const int x = random->Below(canvas->cols);
    const int y = random->Below(canvas->rows);
    const int length = random->Integer(canvas->rows / 12, canvas->rows / 3);
    const int width = random->Integer(1, 5);
    for (int k = 0; k < length; ++k) {
      const double fade = 1.0 - static_cast<double>(k) / length;
      for (int w = 0; w < width; ++w) {
        float& value = mask.at<float>((y + k) % canvas->rows, (x + w) % canvas->cols);
        value = std::max(value, static_cast<float>(fade * strength));
      }
    }
  }
  cv::GaussianBlur(mask, mask, cv::Size(), 1.2);
  Blend(canvas, mask, Rgb(52, 46, 40));
}

void DrawSpots(cv::Mat* canvas, int count, double radius_low, double radius_high, double tone_low,
               double tone_high, Random* random) {
  for (int i = 0; i < count; ++i) {
    const cv::Point at(random->Below(canvas->cols), random->Below(canvas->rows));
    const double radius = random->Uniform(radius_low, radius_high);
    const auto& under = canvas->at<cv::Vec3f>(at);
    const double tone = random->Uniform(tone_low, tone_high);
    const cv::Size axes(std::max(1, static_cast<int>(radius)),
                        std::max(1, static_cast<int>(radius * random->Uniform(0.5, 1.0))));
    cv::ellipse(*canvas, at, axes, random->Uniform(0, 180), 0, 360,
                cv::Scalar(under[0] * tone, under[1] * tone, under[2] * tone), cv::FILLED, cv::LINE_AA);
  }
}

void DrawText(cv::Mat* canvas, const std::string& text, cv::Rect box, int font, const cv::Scalar& rgb,
              double weight) {
  int baseline = 0;
  constexpr double kScale = 2.0;
  const int thickness = std::max(1, static_cast<int>(std::lround(weight * 3)));
  const cv::Size natural = cv::getTextSize(text, font, kScale, thickness, &baseline);
  const cv::Size full(natural.width + 2 * thickness, natural.height + baseline + 2 * thickness);
  cv::Mat mask = cv::Mat::zeros(full, CV_8U);
  cv::putText(mask, text, {thickness, natural.height + thickness}, font, kScale, 255, thickness, cv::LINE_AA);
  box &= cv::Rect(0, 0, canvas->cols, canvas->rows);
  if (box.width < 2 || box.height < 2) return;
  cv::Mat scaled;
  cv::resize(mask, scaled, box.size(), 0, 0, cv::INTER_AREA);
  scaled.convertTo(scaled, CV_32F, 1.0 / 255);
  cv::Mat part = (*canvas)(box);
  cv::Mat painted = part.clone();
  Blend(&painted, scaled, rgb);
  painted.copyTo(part);
}

void FillRect(cv::Mat* canvas, cv::Rect2d box, const cv::Scalar& rgb) {
  constexpr int kShift = 4;
  const cv::Point2d last(box.x + box.width - 1, box.y + box.height - 1);
  cv::rectangle(*canvas, cv::Point(cv::Point2d(box.x, box.y) * (1 << kShift)),
                cv::Point(last * (1 << kShift)), rgb, cv::FILLED, cv::LINE_AA, kShift);
}

cv::Scalar Rgb(int red, int green, int blue) { return {red / 255.0, green / 255.0, blue / 255.0}; }

cv::Scalar Hsv(double hue, double saturation, double value) {
  const auto channel = [&](double n) {
    const double k = std::fmod(n + hue / 60.0, 6.0);
    return value - value * saturation * std::max(0.0, std::min({k, 4.0 - k, 1.0}));
  };
  return {channel(5), channel(3), channel(1)};
}

cv::Scalar Jitter(const cv::Scalar& rgb, double amount, Random* random) {
  const double common = 1.0 + amount * random->Uniform(-1, 1);
  return {rgb[0] * common * (1 + 0.12 * amount * random->Uniform(-1, 1)),
          rgb[1] * common * (1 + 0.12 * amount * random->Uniform(-1, 1)),
          rgb[2] * common * (1 + 0.12 * amount * random->Uniform(-1, 1))};
}

cv::Scalar Scaled(const cv::Scalar& rgb, double factor) {
  return {rgb[0] * factor, rgb[1] * factor, rgb[2] * factor};
}

}  // namespace semmap::town
