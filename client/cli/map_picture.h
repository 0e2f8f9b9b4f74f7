#pragma once

#include <string>

#include <opencv2/core.hpp>

#include "client/cli/map_scene.h"

namespace semmap::client {

enum class MapView { kTop, kPerspective, kBoth };

struct MapPictureOptions {
  MapView view = MapView::kBoth;
  int width = 1800;  // pixels; the height follows from what is drawn
  std::string title;
};

// Points by class in CARLA's colours, the paths over them, with a legend and, from above, a scale bar (as
// figure 6 of the paper). CV_8UC3. Throws what OpenCV throws.
cv::Mat DrawMapPicture(const GroundScene& scene, const MapPictureOptions& options);

// Colour (BGR) of a class; grey for the unknown one.
cv::Scalar ClassColour(uint8_t semantic_class);

// The longest of 1, 2 or 5 times a power of ten that is at most `length`, which is greater than zero.
double RoundLength(double length);

}  // namespace semmap::client
