#pragma once

#include <cstdint>
#include <vector>

#include "slam/features/feature_grid.h"
#include "slam/features/frame_features.h"

namespace semmap {

// Bits out of 256. A pair within the strict bound matches on descriptors alone; the loose bound needs
// geometry to have narrowed the search to a small window first.
constexpr int kStrictDistance = 50;
constexpr int kLooseDistance = 95;

// Descriptor distance of a possible pair, as every association of the pipeline measures it.
inline int AssociationDistance(const Descriptor& a, const Descriptor& b) { return HammingDistance(a, b); }

// A place in an image where a descriptor is expected.
struct WindowQuery {
  float x = 0;
  float y = 0;
  float radius = 0;
  int min_octave = 0;
  int max_octave = 0;
  // Where the right eye should see it; negative: do not care. Compared within the radius.
  float right_x = -1;
  const Descriptor* descriptor = nullptr;
};

struct WindowMatch {
  int keypoint = -1;
  int distance = 257;
  // Distance of the runner-up, and whether it is of the same octave (then it competes for the same surface).
  int second_distance = 257;
  int octave = -1;
  int second_octave = -2;

  // The winner must be clearly better than a runner-up of its own scale.
  bool IsDistinct(double ratio) const {
    return octave != second_octave || distance <= static_cast<int>(ratio * second_distance);
  }
};

// Features of one image with their search index.
struct SearchImage {
  const FrameFeatures& features;
  const FeatureGrid& grid;
};

// The best keypoint for the query among those that `available(index)` admits.
template <typename Available>
WindowMatch FindInWindow(const SearchImage& image, const WindowQuery& query, Available&& available) {
  WindowMatch match;
  image.grid.ForEachInWindow(image.features.keypoints, query.x, query.y, query.radius, [&](int index) {
    const Keypoint& keypoint = image.features.keypoints[index];
    if (keypoint.octave < query.min_octave || keypoint.octave > query.max_octave || !available(index)) return;
    if (query.right_x >= 0 && keypoint.right_x >= 0) {
      const float error = keypoint.right_x - query.right_x;
      if (error > query.radius || error < -query.radius) return;
    }
    const int distance = AssociationDistance(*query.descriptor, image.features.descriptors[index]);
    if (distance < match.distance) {
      match.second_distance = match.distance;
      match.second_octave = match.octave;
      match.distance = distance;
      match.octave = keypoint.octave;
      match.keypoint = index;
    } else if (distance < match.second_distance) {
      match.second_distance = distance;
      match.second_octave = keypoint.octave;
    }
  });
  return match;
}

// A tentative pair of keypoints.
struct KeypointPair {
  int first = -1;
  int second = -1;
  int distance = 0;
};

// Keeps the pairs whose in-plane rotation agrees with the majority: true pairs of a moving camera all turn
// alike.
void KeepConsistentRotation(const std::vector<Keypoint>& first, const std::vector<Keypoint>& second,
                            std::vector<KeypointPair>* pairs);

// Keeps the closest pair of each second keypoint. The order of the first keypoints is kept.
void KeepBestOfSecond(size_t second_count, std::vector<KeypointPair>* pairs);

}  // namespace semmap
