#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include "client/town/materials.h"

namespace semmap::town {

inline cv::Size TextureSize() { return {kTextureSize, kTextureSize}; }

// Paints one layer: CV_8UC4, RGBA, kTextureSize squared, top row first. Depends on its arguments alone.
cv::Mat PaintTexture(Texture texture, uint64_t seed);

// All layers, in the order of Texture.
std::vector<cv::Mat> PaintAllTextures(uint64_t seed);

// The large-scale stains that keep two places with the same texture apart: CV_8UC2, kGrimeSize squared,
// repeating; channel 0 large stains, channel 1 fine spots; 128 is neutral.
cv::Mat PaintGrime(uint64_t seed);
inline constexpr int kGrimeSize = 2048;
inline constexpr float kGrimeMetres = 37.3F;  // size of one repetition

// Painters of families of layers, one per file; RGB canvas in, alpha (CV_32F, 1 where solid) filled where cut
// out.
void PaintGround(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);
void PaintWall(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);
void PaintOpening(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);
void PaintSign(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);
void PaintNature(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);
void PaintBarrier(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);
void PaintVehicle(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);
void PaintPeople(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha);

}  // namespace semmap::town
