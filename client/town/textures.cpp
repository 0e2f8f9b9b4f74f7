#include "client/town/textures.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"

namespace semmap::town {
namespace {

constexpr uint64_t kGrimePurpose = 31;

bool Between(Texture texture, Texture first, Texture last) { return texture >= first && texture <= last; }

void PaintInto(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha) {
  if (Between(texture, Texture::kAsphalt0, Texture::kPaint)) return PaintGround(texture, seed, rgb, alpha);
  if (Between(texture, Texture::kBrick0, Texture::kRoofFelt)) return PaintWall(texture, seed, rgb, alpha);
  if (Between(texture, Texture::kGrass, Texture::kBush)) return PaintNature(texture, seed, rgb, alpha);
  if (Between(texture, Texture::kWindows0, Texture::kShops7)) return PaintOpening(texture, seed, rgb, alpha);
  if (Between(texture, Texture::kShopSigns0, Texture::kRoadArrows))
    return PaintSign(texture, seed, rgb, alpha);
  if (Between(texture, Texture::kFencePickets, Texture::kTruss))
    return PaintBarrier(texture, seed, rgb, alpha);
  if (Between(texture, Texture::kCar0, Texture::kWheels)) return PaintVehicle(texture, seed, rgb, alpha);
  if (Between(texture, Texture::kCloth0, Texture::kBins)) return PaintPeople(texture, seed, rgb, alpha);
  return PaintNature(texture, seed, rgb, alpha);  // the sky
}

}  // namespace

float TileMetres(Texture texture) {
  switch (texture) {
    case Texture::kAsphalt0:
    case Texture::kAsphalt1:
    case Texture::kAsphalt2:
      return 4.3F;
    case Texture::kPavingSlabs0:
    case Texture::kPavingSlabs1:
      return 3.6F;
    case Texture::kSetts:
      return 2.4F;
    case Texture::kBrick0:
    case Texture::kBrick1:
    case Texture::kBrick2:
      return 2.7F;
    case Texture::kAshlar0:
    case Texture::kAshlar1:
    case Texture::kPanels:
      return 4.8F;
    case Texture::kPlaster0:
    case Texture::kPlaster1:
    case Texture::kPlaster2:
    case Texture::kPlasterBroken:
      return 5.1F;
    case Texture::kGrass:
    case Texture::kSoil:
    case Texture::kWater:
      return 4.7F;
    case Texture::kRoofTiles:
    case Texture::kSlate:
      return 3.0F;
    case Texture::kBark:
      return 1.6F;
    default:
      return 3.1F;
  }
}

cv::Mat PaintTexture(Texture texture, uint64_t seed) {
  const cv::Size size(kTextureSize, kTextureSize);
  cv::Mat rgb = Filled(size, Rgb(128, 128, 128));
  cv::Mat alpha = cv::Mat::ones(size, CV_32F);
  PaintInto(texture, seed, &rgb, &alpha);
  std::vector<cv::Mat> channels;
  cv::split(rgb, channels);
  channels.push_back(alpha);
  cv::Mat rgba;
  cv::merge(channels, rgba);
  rgba.convertTo(rgba, CV_8UC4, 255.0);
  return rgba;
}

std::vector<cv::Mat> PaintAllTextures(uint64_t seed) {
  std::vector<cv::Mat> layers(kTextureCount);
  cv::parallel_for_(cv::Range(0, kTextureCount), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      layers[static_cast<size_t>(i)] = PaintTexture(static_cast<Texture>(i), seed);
    }
  });
  return layers;
}

cv::Mat PaintGrime(uint64_t seed) {
  Random random(seed, kGrimePurpose);
  const cv::Size size(kGrimeSize, kGrimeSize);
  // Large soft stains, on which sharp-edged patches lie: edges are what a corner detector finds far away.
  cv::Mat large = Noise(size, {12, 12}, 7, 0.62, &random);
  const cv::Mat ragged = Noise(size, {24, 24}, 6, 0.7, &random);
  large = 0.7 * large - 0.9 * SmoothMask(ragged, 1.1, 1.35) + 0.7 * SmoothMask(ragged, -1.45, -1.7);
  cv::Mat fine = Noise(size, {200, 200}, 3, 0.8, &random);
  const cv::Mat spots = Noise(size, {330, 330}, 2, 0.6, &random);
  fine = 0.55 * fine - 1.5 * SmoothMask(spots, 1.6, 1.9) + 1.1 * SmoothMask(spots, -1.75, -2.0);
  std::vector<cv::Mat> channels = {large, fine};
  for (cv::Mat& channel : channels) channel.convertTo(channel, CV_8U, 42.0, 128.0);
  cv::Mat grime;
  cv::merge(channels, grime);
  return grime;
}

}  // namespace semmap::town
