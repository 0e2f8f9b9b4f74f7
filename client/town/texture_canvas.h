#pragma once

#include <string>

#include <opencv2/core.hpp>

#include "client/town/random.h"

namespace semmap::town {

// Tools for painting textures. Canvases are CV_32FC3, RGB in [0, 1], and repeat at their borders unless a
// painter says otherwise; noise is CV_32F.

// Sum of `octaves` of value noise, the first with `cells` cells across the canvas, each next twice as fine
// and `gain` times as strong; about mean 0, deviation 1; repeats at the borders. `cells` may differ in x and
// y.
cv::Mat Noise(cv::Size size, cv::Size cells, int octaves, double gain, Random* random);
// Independent noise of each texel, blurred by `sigma` texels, mean 0, deviation 1.
cv::Mat Speckle(cv::Size size, double sigma, Random* random);

cv::Mat Filled(cv::Size size, const cv::Scalar& rgb);
// canvas *= 1 + strength * noise, in each channel.
void Modulate(cv::Mat* canvas, const cv::Mat& noise, double strength);
// canvas = mix(canvas, rgb, mask), mask CV_32F in [0, 1].
void Blend(cv::Mat* canvas, const cv::Mat& mask, const cv::Scalar& rgb);
// smooth step of noise between two levels, as a mask
cv::Mat SmoothMask(const cv::Mat& noise, double low, double high);

// Dark wandering cracks, drawn with wrap-around.
void DrawCracks(cv::Mat* canvas, int count, double length, const cv::Scalar& rgb, double thickness,
                Random* random);
// Dark streaks running down from random places.
void DrawStreaks(cv::Mat* canvas, int count, double strength, Random* random);
// Round spots of random size and tone.
void DrawSpots(cv::Mat* canvas, int count, double radius_low, double radius_high, double tone_low,
               double tone_high, Random* random);
// Text stretched to fill `box`, with a stroke of `weight` times its natural thickness.
void DrawText(cv::Mat* canvas, const std::string& text, cv::Rect box, int font, const cv::Scalar& rgb,
              double weight);
// A filled rectangle, with soft edges of one texel.
void FillRect(cv::Mat* canvas, cv::Rect2d box, const cv::Scalar& rgb);

cv::Scalar Rgb(int red, int green, int blue);
// A colour of given hue (degrees), saturation and value.
cv::Scalar Hsv(double hue, double saturation, double value);
cv::Scalar Jitter(const cv::Scalar& rgb, double amount, Random* random);
cv::Scalar Scaled(const cv::Scalar& rgb, double factor);

}  // namespace semmap::town
