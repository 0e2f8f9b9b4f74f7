#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/features/descriptor.h"
#include "slam/semantics/taxonomy.h"

namespace semmap {

// A corner in undistorted pixel coordinates of the left (or only) image.
struct Keypoint {
  float x = 0;
  float y = 0;
  // Column in the rectified right image (stereo) or of the virtual right camera (RGB-D); negative: no depth.
  float right_x = -1;
  // Metres along z of the camera; not positive: unknown.
  float depth = -1;
  // Radians, [0, 2 pi).
  float angle = 0;
  // Pyramid level, 0 is full resolution.
  uint8_t octave = 0;
  // Id of SemanticClass, kUnknownClass when nobody said; and its probability, 255 = certain, 0 = taken over
  // from the point it shows. The store does not keep the latter.
  uint8_t semantic_class = kUnknownClass;
  uint8_t class_confidence = 255;
  // Another class that begins within a few pixels: half a pixel decides which of the two such a corner gets.
  // Not stored.
  uint8_t class_beside = kUnknownClass;

  bool HasDepth() const { return depth > 0; }
};

// What remains of an image after extraction. keypoints[i] belongs to descriptors[i].
struct FrameFeatures {
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
  // Of features that come from a store which kept only some of a frame's: which keypoint of the frame each
  // one was, ascending. Empty: all are there.
  std::vector<uint32_t> frame_index;

  size_t size() const { return keypoints.size(); }
};

// Scale of each pyramid level: factor^level.
struct ScalePyramidInfo {
  ScalePyramidInfo(int levels, double factor) {
    double scale = 1.0;
    for (int level = 0; level < levels; ++level, scale *= factor) {
      scales.push_back(static_cast<float>(scale));
      // Corners are located to about one pixel of their own level.
      inverse_sigma2.push_back(static_cast<float>(1.0 / (scale * scale)));
    }
    scale_factor = static_cast<float>(factor);
  }
  int levels() const { return static_cast<int>(scales.size()); }

  float scale_factor = 1.2F;
  std::vector<float> scales;
  std::vector<float> inverse_sigma2;
};

}  // namespace semmap
