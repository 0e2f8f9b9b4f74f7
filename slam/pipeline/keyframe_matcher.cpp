#include "slam/pipeline/keyframe_matcher.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <span>

#include "slam/features/descriptor_search.h"

namespace semmap {
namespace {

constexpr double kDistinctRatio = 0.75;

bool IsMatch(const NearestTwo& nearest) {
  return nearest.index >= 0 && nearest.distance <= kStrictDistance &&
         nearest.distance <= static_cast<int>(kDistinctRatio * nearest.second_distance);
}

// As FindNearestTwo, by the rule.
NearestTwo FindNearestTwoByRule(const AssociationRule& rule, const Descriptor& wanted, uint8_t semantic_class,
                                const FrameFeatures& image, std::span<const int> candidates) {
  NearestTwo nearest;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const int distance = rule.Distance(wanted, semantic_class, image.descriptors[candidates[i]],
                                       image.keypoints[candidates[i]]);
    if (distance < nearest.distance) {
      nearest.second_distance = nearest.distance;
      nearest.distance = distance;
      nearest.index = static_cast<int>(i);
    } else {
      nearest.second_distance = std::min(nearest.second_distance, distance);
    }
  }
  return nearest;
}

std::vector<KeypointPair> Sift(const FrameFeatures& keyframe, const FrameFeatures& image,
                               std::vector<KeypointPair> pairs) {
  KeepBestOfSecond(image.size(), &pairs);
  KeepConsistentRotation(keyframe.keypoints, image.keypoints, &pairs);
  return pairs;
}

// `class_of(i)` is the class of the point that keypoint i sees; nothing where it sees none.
template <typename ClassOf>
std::vector<KeypointPair> MatchAll(const AssociationRule& rule, const FrameFeatures& keyframe,
                                   const ClassOf& class_of, const FrameFeatures& image) {
  std::vector<KeypointPair> pairs;
  std::vector<int> all(image.size());
  std::iota(all.begin(), all.end(), 0);
  for (size_t i = 0; i < keyframe.size(); ++i) {
    const std::optional<uint8_t> semantic_class = class_of(i);
    if (!semantic_class) continue;
    const Descriptor& wanted = keyframe.descriptors[i];
    const NearestTwo nearest = rule.Matters(*semantic_class)
                                   ? FindNearestTwoByRule(rule, wanted, *semantic_class, image, all)
                                   : FindNearestTwo(wanted, image.descriptors);
    if (IsMatch(nearest)) pairs.push_back({static_cast<int>(i), nearest.index, nearest.distance});
  }
  return Sift(keyframe, image, std::move(pairs));
}

template <typename ClassOf>
std::vector<KeypointPair> MatchNodes(const AssociationRule& rule, const FrameFeatures& keyframe,
                                     const ClassOf& class_of, const DirectIndex& keyframe_nodes,
                                     const FrameFeatures& image, const DirectIndex& image_nodes) {
  std::vector<KeypointPair> pairs;
  std::vector<int> candidates;
  auto group = image_nodes.groups.begin();
  for (const NodeGroup& wanted : keyframe_nodes.groups) {
    while (group != image_nodes.groups.end() && group->node < wanted.node) ++group;
    if (group == image_nodes.groups.end()) break;
    if (group->node != wanted.node) continue;
    candidates.assign(image_nodes.keypoints.begin() + group->begin,
                      image_nodes.keypoints.begin() + group->end);
    for (uint32_t i = wanted.begin; i < wanted.end; ++i) {
      const uint32_t keypoint = keyframe_nodes.keypoints[i];
      const std::optional<uint8_t> semantic_class = class_of(keypoint);
      if (!semantic_class) continue;
      const Descriptor& descriptor = keyframe.descriptors[keypoint];
      const NearestTwo nearest =
          rule.Matters(*semantic_class)
              ? FindNearestTwoByRule(rule, descriptor, *semantic_class, image, candidates)
              : FindNearestTwo(descriptor, image.descriptors, candidates);
      if (!IsMatch(nearest)) continue;
      pairs.push_back({static_cast<int>(keypoint), candidates[nearest.index], nearest.distance});
    }
  }
  return Sift(keyframe, image, std::move(pairs));
}

// Class of the active point that a keypoint sees; nothing where it sees none.
auto ClassesIn(const Map& map, const KeyFrame& keyframe) {
  return [&](size_t keypoint) -> std::optional<uint8_t> {
    const MapPoint* point = map.FindActivePoint(keyframe.points[keypoint]);
    return point == nullptr ? std::nullopt : std::optional<uint8_t>(point->semantic_class);
  };
}

auto ClassesIn(const LocalMapView& view, const ViewKeyFrame& keyframe) {
  return [&](size_t keypoint) -> std::optional<uint8_t> {
    const int32_t point = keyframe.point_of_keypoint[keypoint];
    return point < 0 ? std::nullopt : std::optional<uint8_t>(view.classes[point]);
  };
}

}  // namespace

std::vector<KeypointPair> MatchWithinNodes(const AssociationRule& rule, const Map& map,
                                           const KeyFrame& keyframe, const DirectIndex& keyframe_nodes,
                                           const FrameFeatures& image, const DirectIndex& image_nodes) {
  return MatchNodes(rule, *keyframe.features, ClassesIn(map, keyframe), keyframe_nodes, image, image_nodes);
}

std::vector<KeypointPair> MatchWithinNodes(const AssociationRule& rule, const LocalMapView& view,
                                           const ViewKeyFrame& keyframe, const DirectIndex& keyframe_nodes,
                                           const FrameFeatures& image, const DirectIndex& image_nodes) {
  return MatchNodes(rule, *keyframe.features, ClassesIn(view, keyframe), keyframe_nodes, image, image_nodes);
}

std::vector<KeypointPair> MatchExhaustively(const AssociationRule& rule, const Map& map,
                                            const KeyFrame& keyframe, const FrameFeatures& image) {
  return MatchAll(rule, *keyframe.features, ClassesIn(map, keyframe), image);
}

std::vector<KeypointPair> MatchExhaustively(const AssociationRule& rule, const LocalMapView& view,
                                            const ViewKeyFrame& keyframe, const FrameFeatures& image) {
  return MatchAll(rule, *keyframe.features, ClassesIn(view, keyframe), image);
}

}  // namespace semmap
