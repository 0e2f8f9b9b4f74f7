#pragma once

#include <cstdint>
#include <vector>

#include "slam/features/feature_grid.h"
#include "slam/features/frame_features.h"
#include "slam/semantics/semantics_config.h"

namespace semmap {

// Bits out of 256. A pair within the strict bound matches on descriptors alone; the loose bound needs
// geometry to have narrowed the search to a small window first.
constexpr int kStrictDistance = 50;
constexpr int kLooseDistance = 95;

// More than any two descriptors can differ.
constexpr int kNoDistance = 257;

// How far apart the two sides of a possible pair are, as every association of the pipeline measures it: the
// distance of their descriptors, raised by a share of itself where they are known to be of different classes
// (section 4 of the paper). A side is a keypoint with its class (where two classes meet, with both), or a map
// point with the class of its votes.
// A value.
class AssociationRule {
 public:
  // Classes do not matter.
  AssociationRule() = default;
  explicit AssociationRule(const SemanticsConfig& config)
      : penalty_(config.enabled ? config.penalty : 0.0), strict_(config.enabled && config.strict) {}

  // Of a map point, or a keypoint that shows one, to a keypoint of an image.
  int Distance(const Descriptor& a, uint8_t class_a, const Descriptor& b, const Keypoint& keypoint_b) const {
    const int distance = HammingDistance(a, b);
    return Differ(class_a, keypoint_b) ? OfDifferent(distance) : distance;
  }
  // Of two keypoints.
  int Distance(const Descriptor& a, const Keypoint& keypoint_a, const Descriptor& b,
               const Keypoint& keypoint_b) const {
    const int distance = HammingDistance(a, b);
    const bool differ =
        Differ(keypoint_a.semantic_class, keypoint_b) &&
        (keypoint_a.class_beside == kUnknownClass || Differ(keypoint_a.class_beside, keypoint_b));
    return differ ? OfDifferent(distance) : distance;
  }
  // False when all pairs with this class are measured by their descriptors alone.
  bool Matters(uint8_t semantic_class) const {
    return semantic_class != kUnknownClass && (penalty_ > 0 || strict_);
  }

 private:
  static bool Differ(uint8_t a, const Keypoint& b) {
    return a != b.semantic_class && a != kUnknownClass && b.semantic_class != kUnknownClass &&
           a != b.class_beside;
  }
  int OfDifferent(int distance) const {
    return strict_ ? kNoDistance : distance + static_cast<int>(penalty_ * distance);
  }

  double penalty_ = 0;
  bool strict_ = false;
};

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
  uint8_t semantic_class = kUnknownClass;
};

struct WindowMatch {
  int keypoint = -1;
  int distance = kNoDistance;
  // Distance of the runner-up, and whether it is of the same octave (then it competes for the same surface).
  int second_distance = kNoDistance;
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
WindowMatch FindInWindow(const AssociationRule& rule, const SearchImage& image, const WindowQuery& query,
                         Available&& available) {
  WindowMatch match;
  image.grid.ForEachInWindow(image.features.keypoints, query.x, query.y, query.radius, [&](int index) {
    const Keypoint& keypoint = image.features.keypoints[index];
    if (keypoint.octave < query.min_octave || keypoint.octave > query.max_octave || !available(index)) return;
    if (query.right_x >= 0 && keypoint.right_x >= 0) {
      const float error = keypoint.right_x - query.right_x;
      if (error > query.radius || error < -query.radius) return;
    }
    const int distance =
        rule.Distance(*query.descriptor, query.semantic_class, image.features.descriptors[index], keypoint);
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
