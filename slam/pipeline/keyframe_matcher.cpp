#include "slam/pipeline/keyframe_matcher.h"

#include <span>

#include "slam/features/descriptor_search.h"

namespace semmap {
namespace {

constexpr double kDistinctRatio = 0.75;

bool IsMatch(const NearestTwo& nearest) {
  return nearest.index >= 0 && nearest.distance <= kStrictDistance &&
         nearest.distance <= static_cast<int>(kDistinctRatio * nearest.second_distance);
}

std::vector<KeypointPair> Sift(const FrameFeatures& keyframe, const FrameFeatures& image,
                               std::vector<KeypointPair> pairs) {
  KeepBestOfSecond(image.size(), &pairs);
  KeepConsistentRotation(keyframe.keypoints, image.keypoints, &pairs);
  return pairs;
}

template <typename SeesPoint>
std::vector<KeypointPair> MatchAll(const FrameFeatures& keyframe, const SeesPoint& sees_point,
                                   const FrameFeatures& image) {
  std::vector<KeypointPair> pairs;
  for (size_t i = 0; i < keyframe.size(); ++i) {
    if (!sees_point(i)) continue;
    const NearestTwo nearest = FindNearestTwo(keyframe.descriptors[i], image.descriptors);
    if (IsMatch(nearest)) pairs.push_back({static_cast<int>(i), nearest.index, nearest.distance});
  }
  return Sift(keyframe, image, std::move(pairs));
}

}  // namespace

std::vector<KeypointPair> MatchWithinNodes(const KeyFrame& keyframe, const DirectIndex& keyframe_nodes,
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
      if (!keyframe.points[keypoint].IsValid()) continue;
      const NearestTwo nearest =
          FindNearestTwo(keyframe.features->descriptors[keypoint], image.descriptors, candidates);
      if (!IsMatch(nearest)) continue;
      pairs.push_back({static_cast<int>(keypoint), candidates[nearest.index], nearest.distance});
    }
  }
  return Sift(*keyframe.features, image, std::move(pairs));
}

std::vector<KeypointPair> MatchExhaustively(const KeyFrame& keyframe, const FrameFeatures& image) {
  return MatchAll(
      *keyframe.features, [&](size_t i) { return keyframe.points[i].IsValid(); }, image);
}

std::vector<KeypointPair> MatchExhaustively(const ViewKeyFrame& keyframe, const FrameFeatures& image) {
  return MatchAll(
      *keyframe.features, [&](size_t i) { return keyframe.point_of_keypoint[i] >= 0; }, image);
}

}  // namespace semmap
