#include "slam/pipeline/monocular_initializer.h"

#include <algorithm>

namespace semmap {
namespace {

constexpr size_t kMinKeypoints = 100;
constexpr size_t kMinPairs = 100;
constexpr double kDistinctRatio = 0.9;
constexpr uint64_t kMaxAgeFrames = 30;

// How far a keypoint may move between two frames, as a share of the image width.
constexpr float kSearchShare = 0.08F;

double MedianDepth(const std::vector<InitialReconstruction::Point>& points) {
  std::vector<double> depths;
  for (const auto& point : points) depths.push_back(point.position_in_first.z());
  std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
  return depths[depths.size() / 2];
}

void NormalizeScale(InitialReconstruction* result) {
  const double factor = 1.0 / MedianDepth(result->points);
  for (auto& point : result->points) point.position_in_first *= factor;
  result->second_from_first =
      SE3(result->second_from_first.rotation(), factor * result->second_from_first.translation());
}

}  // namespace

void MonocularInitializer::StartOver(const TrackedFrame& frame) {
  reference_.reset();
  if (frame.features->size() < kMinKeypoints) return;
  reference_ = frame;
  last_seen_.clear();
  for (const Keypoint& keypoint : frame.features->keypoints) last_seen_.emplace_back(keypoint.x, keypoint.y);
}

std::optional<InitialReconstruction> MonocularInitializer::Add(const TrackedFrame& frame) {
  if (!reference_ || frame.sequence > reference_->sequence + kMaxAgeFrames) {
    StartOver(frame);
    return std::nullopt;
  }
  const std::vector<KeypointPair> pairs = Match(frame);
  if (pairs.size() < kMinPairs) {
    StartOver(frame);
    return std::nullopt;
  }
  return Reconstruct(frame, pairs);
}

std::vector<KeypointPair> MonocularInitializer::Match(const TrackedFrame& frame) {
  const FrameFeatures& reference = *reference_->features;
  const SearchImage image{*frame.features, *frame.grid};
  const float radius = kSearchShare * static_cast<float>(camera_.width);
  std::vector<KeypointPair> pairs;
  const auto is_active = [&](int keypoint) {
    return !inactive_.Contains(frame.features->keypoints[keypoint].semantic_class);
  };
  for (size_t i = 0; i < reference.size(); ++i) {
    const uint8_t semantic_class = reference.keypoints[i].semantic_class;
    if (inactive_.Contains(semantic_class)) continue;
    const int octave = reference.keypoints[i].octave;
    const WindowQuery query{last_seen_[i].x(),         last_seen_[i].y(), radius, octave - 1, octave + 1, -1,
                            &reference.descriptors[i], semantic_class};
    const WindowMatch match = FindInWindow(rule_, image, query, is_active);
    if (match.keypoint < 0 || match.distance > kStrictDistance) continue;
    if (match.distance > static_cast<int>(kDistinctRatio * match.second_distance)) continue;
    pairs.push_back({static_cast<int>(i), match.keypoint, match.distance});
  }
  KeepBestOfSecond(frame.features->size(), &pairs);
  KeepConsistentRotation(reference.keypoints, frame.features->keypoints, &pairs);
  for (const KeypointPair& pair : pairs) {
    const Keypoint& seen = frame.features->keypoints[pair.second];
    last_seen_[pair.first] = {seen.x, seen.y};
  }
  return pairs;
}

std::optional<InitialReconstruction> MonocularInitializer::Reconstruct(
    const TrackedFrame& frame, const std::vector<KeypointPair>& pairs) {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
  for (const KeypointPair& pair : pairs) {
    const Keypoint& a = reference_->features->keypoints[pair.first];
    const Keypoint& b = frame.features->keypoints[pair.second];
    first.emplace_back(a.x, a.y);
    second.emplace_back(b.x, b.y);
  }
  TwoViewOptions options;
  options.seed = seed_;
  const auto reconstruction = ReconstructTwoViews(camera_, first, second, options);
  if (!reconstruction) return std::nullopt;
  InitialReconstruction result{*reference_, reconstruction->second_from_first, {}};
  for (size_t i = 0; i < pairs.size(); ++i) {
    const auto& point = reconstruction->points_in_first[i];
    if (point) result.points.push_back({*point, pairs[i].first, pairs[i].second});
  }
  if (result.points.empty()) return std::nullopt;
  NormalizeScale(&result);
  return result;
}

}  // namespace semmap
