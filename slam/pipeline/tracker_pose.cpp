// The part of Tracker that finds the pose of a frame: from the last frame, from a keyframe, in the local map.
#include <algorithm>

#include "slam/geometry/pnp.h"
#include "slam/pipeline/stopwatch.h"
#include "slam/pipeline/tracker.h"

namespace semmap {
namespace {

constexpr int kMinMatches = 20;
constexpr int kMinInliers = 10;
constexpr int kMinRelocalizationInliers = 50;
// Search windows in pixels of octave 0.
constexpr float kMotionRadius = 12;
constexpr float kMotionRadiusDepth = 8;
constexpr float kMapRadius = 3;
constexpr float kMapRadiusAfterLoss = 8;
constexpr double kDescriptorRatio = 0.75;
// Depth anchors: as many of the nearest, or all that are close.
constexpr size_t kMinDepthAnchors = 100;

}  // namespace

bool Tracker::FindInitialPose(TrackedFrame* frame) {
  Stopwatch stopwatch;
  const double optimize_before = times_.optimize_ms;
  relocalizing_ = false;
  inlier_share_ = 0;
  bool found = false;
  if (state_ != TrackingState::kLost && last_) {
    found = TrackFromLastFrame(frame);
    if (!found) {
      frame->camera_from_map = last_->camera_from_map;
      found = TrackFromKeyFrame(view_->reference(), frame);
    }
  }
  if (!found) found = relocalizing_ = Relocalize(frame);
  times_.match_ms += stopwatch.LapMs() - (times_.optimize_ms - optimize_before);
  return found;
}

bool Tracker::Locate(TrackedFrame* frame, FrameResult* result) {
  const bool found = FindInitialPose(frame) && TrackLocalMap(frame, result);
  doubtful_ = inlier_share_ < config_.tracking.doubtful_inlier_share;
  if (relocalizing_ || (found && !doubtful_)) return found;
  // Far points alone fit a pose that is metres off. What the near keyframes say counts if more agrees with
  // it.
  const SE3 camera_from_map = frame->camera_from_map;
  const FrameResult first = *result;
  const ViewMatches first_matches = matches_;
  const double first_share = inlier_share_;
  relocalizing_ = true;
  if (Relocalize(frame) && TrackLocalMap(frame, result) && (!found || result->inliers > first.inliers)) {
    doubtful_ = inlier_share_ < config_.tracking.doubtful_inlier_share;
    return true;
  }
  if (!found) return false;
  frame->camera_from_map = camera_from_map;
  *result = first;
  matches_ = first_matches;
  inlier_share_ = first_share;
  relocalizing_ = false;
  return true;
}

// --- from the last frame

std::vector<Tracker::Anchor> Tracker::LastFrameAnchors() const {
  std::vector<Anchor> anchors;
  std::vector<std::pair<float, int>> by_depth;
  const std::vector<Keypoint>& keypoints = last_->features->keypoints;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    const int32_t index = last_points_[i].IsValid() ? view_->IndexOf(last_points_[i]) : -1;
    if (index >= 0) {
      anchors.push_back({static_cast<int>(i), index, view_->positions[index]});
    } else if (keypoints[i].HasDepth()) {
      by_depth.emplace_back(keypoints[i].depth, static_cast<int>(i));
    }
  }
  std::sort(by_depth.begin(), by_depth.end());
  const double close = config_.tracking.close_depth_in_baselines * builder_.rig().baseline_m;
  const SE3 map_from_last = last_->camera_from_map.Inverse();
  for (size_t n = 0; n < by_depth.size(); ++n) {
    const auto& [depth, keypoint] = by_depth[n];
    if (n >= kMinDepthAnchors && depth > close) break;
    const Eigen::Vector2d pixel(keypoints[keypoint].x, keypoints[keypoint].y);
    anchors.push_back({keypoint, -1, map_from_last * (depth * RayOfPixel(builder_.rig().camera, pixel))});
  }
  return anchors;
}

int Tracker::MatchAnchors(const std::vector<Anchor>& anchors, const SE3& predicted_camera_from_map,
                          float radius, const TrackedFrame& frame) {
  const SearchImage image{*frame.features, *frame.grid};
  const FrameFeatures& last = *last_->features;
  std::vector<KeypointPair> pairs;  // first: index into anchors
  std::vector<Keypoint> anchor_keypoints(anchors.size());
  for (size_t i = 0; i < anchors.size(); ++i) {
    const Keypoint& seen = anchor_keypoints[i] = last.keypoints[anchors[i].keypoint];
    const Eigen::Vector3d point = predicted_camera_from_map * anchors[i].position_in_map;
    if (point.z() <= 0) continue;
    const Eigen::Vector2d pixel = ProjectPinhole(builder_.rig().camera, point);
    const auto x = static_cast<float>(pixel.x());
    const auto y = static_cast<float>(pixel.y());
    if (!builder_.bounds().Contains(x, y)) continue;
    const double shift = search_.model.focal_times_baseline / point.z();
    const WindowQuery query{x,
                            y,
                            radius * builder_.scale_info().scales[seen.octave],
                            seen.octave - 1,
                            seen.octave + 1,
                            shift > 0 ? static_cast<float>(pixel.x() - shift) : -1.0F,
                            &last.descriptors[anchors[i].keypoint]};
    const WindowMatch match = FindInWindow(image, query, [](int) { return true; });
    if (match.keypoint >= 0 && match.distance <= kLooseDistance) {
      pairs.push_back({static_cast<int>(i), match.keypoint, match.distance});
    }
  }
  KeepBestOfSecond(frame.features->size(), &pairs);
  KeepConsistentRotation(anchor_keypoints, frame.features->keypoints, &pairs);
  std::fill(matches_.begin(), matches_.end(), -1);
  std::fill(depth_matches_.begin(), depth_matches_.end(), std::nullopt);
  for (const KeypointPair& pair : pairs) {
    const Anchor& anchor = anchors[pair.first];
    if (anchor.view_index >= 0) {
      matches_[pair.second] = anchor.view_index;
    } else {
      depth_matches_[pair.second] = anchor.position_in_map;
    }
  }
  return static_cast<int>(pairs.size());
}

bool Tracker::TrackFromLastFrame(TrackedFrame* frame) {
  const SE3 predicted = velocity_ ? *velocity_ * last_->camera_from_map : last_->camera_from_map;
  const std::vector<Anchor> anchors = LastFrameAnchors();
  const bool has_depth = builder_.rig().sensor != SensorType::kMono;
  float radius = has_depth ? kMotionRadiusDepth : kMotionRadius;
  // Without a velocity the prediction is only where the camera was.
  if (!velocity_) radius *= 3;
  int matched = MatchAnchors(anchors, predicted, radius, *frame);
  if (matched < kMinMatches) matched = MatchAnchors(anchors, predicted, 2.5F * radius, *frame);
  if (matched < kMinMatches) return false;
  frame->camera_from_map = predicted;
  Matrix6d covariance;
  return OptimizeFrame(frame, &covariance) >= kMinInliers;
}

// --- from a keyframe, by descriptors alone

std::vector<KeypointPair> Tracker::MatchByDescriptor(const ViewKeyFrame& keyframe,
                                                     const TrackedFrame& frame) const {
  std::vector<KeypointPair> pairs;
  for (size_t i = 0; i < keyframe.point_of_keypoint.size(); ++i) {
    if (keyframe.point_of_keypoint[i] < 0) continue;
    const Descriptor& wanted = keyframe.features->descriptors[i];
    KeypointPair best{static_cast<int>(i), -1, 257};
    int second = 257;
    for (size_t j = 0; j < frame.features->size(); ++j) {
      const int distance = AssociationDistance(wanted, frame.features->descriptors[j]);
      if (distance < best.distance) {
        second = std::exchange(best.distance, distance);
        best.second = static_cast<int>(j);
      } else {
        second = std::min(second, distance);
      }
    }
    if (best.distance <= kStrictDistance && best.distance <= static_cast<int>(kDescriptorRatio * second)) {
      pairs.push_back(best);
    }
  }
  KeepBestOfSecond(frame.features->size(), &pairs);
  KeepConsistentRotation(keyframe.features->keypoints, frame.features->keypoints, &pairs);
  return pairs;
}

bool Tracker::TrackFromKeyFrame(const ViewKeyFrame& keyframe, TrackedFrame* frame) {
  const std::vector<KeypointPair> pairs = MatchByDescriptor(keyframe, *frame);
  if (pairs.size() < kMinInliers) return false;
  std::fill(matches_.begin(), matches_.end(), -1);
  std::fill(depth_matches_.begin(), depth_matches_.end(), std::nullopt);
  for (const KeypointPair& pair : pairs) matches_[pair.second] = keyframe.point_of_keypoint[pair.first];
  Matrix6d covariance;
  return OptimizeFrame(frame, &covariance) >= kMinMatches;
}

bool Tracker::Relocalize(TrackedFrame* frame) {
  for (const ViewKeyFrame& keyframe : view_->keyframes) {
    const std::vector<KeypointPair> pairs = MatchByDescriptor(keyframe, *frame);
    if (pairs.size() < kMinMatches) continue;
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> pixels;
    for (const KeypointPair& pair : pairs) {
      points.push_back(view_->positions[keyframe.point_of_keypoint[pair.first]]);
      const Keypoint& keypoint = frame->features->keypoints[pair.second];
      pixels.emplace_back(keypoint.x, keypoint.y);
    }
    PnpOptions options;
    options.seed = static_cast<uint32_t>(config_.seed);
    const auto pose = EstimatePose(builder_.rig().camera, points, pixels, options);
    if (!pose) continue;
    frame->camera_from_map = pose->camera_from_map;
    std::fill(matches_.begin(), matches_.end(), -1);
    std::fill(depth_matches_.begin(), depth_matches_.end(), std::nullopt);
    for (const KeypointPair& pair : pairs) matches_[pair.second] = keyframe.point_of_keypoint[pair.first];
    Matrix6d covariance;
    if (OptimizeFrame(frame, &covariance) >= kMinInliers) return true;
  }
  return false;
}

// --- in the local map

bool Tracker::TrackLocalMap(TrackedFrame* frame, FrameResult* result) {
  Stopwatch stopwatch;
  // Depth anchors are one noisy measurement each; from here on the map's points say more.
  std::fill(depth_matches_.begin(), depth_matches_.end(), std::nullopt);
  search_.radius = relocalizing_ ? kMapRadiusAfterLoss : kMapRadius;
  const int expected = MatchLocalMap(*view_, frame->camera_from_map, {*frame->features, *frame->grid},
                                     search_, &counters_, &matches_);
  times_.match_ms += stopwatch.LapMs();
  result->inliers = OptimizeFrame(frame, &result->covariance);
  inlier_share_ = result->inliers / std::max(1.0, static_cast<double>(expected));
  const int needed = relocalizing_ ? kMinRelocalizationInliers : config_.tracking.min_inliers_map;
  return result->inliers >= needed && inlier_share_ >= config_.tracking.min_inlier_share;
}

void Tracker::GatherObservations(const TrackedFrame& frame) {
  observations_.clear();
  observed_keypoints_.clear();
  for (size_t i = 0; i < matches_.size(); ++i) {
    if (matches_[i] < 0 && !depth_matches_[i]) continue;
    const Keypoint& keypoint = frame.features->keypoints[i];
    PoseObservation observation;
    observation.point_in_map = matches_[i] >= 0 ? view_->positions[matches_[i]] : *depth_matches_[i];
    observation.pixel = {keypoint.x, keypoint.y, keypoint.right_x,
                         builder_.scale_info().inverse_sigma2[keypoint.octave]};
    observations_.push_back(observation);
    observed_keypoints_.push_back(static_cast<int>(i));
  }
}

int Tracker::OptimizeFrame(TrackedFrame* frame, Matrix6d* covariance) {
  Stopwatch stopwatch;
  GatherObservations(*frame);
  const PoseEstimate estimate =
      OptimizePose(builder_.model(), frame->camera_from_map, observations_, &outliers_);
  frame->camera_from_map = estimate.camera_from_map;
  *covariance = estimate.covariance;
  int map_inliers = 0;
  for (size_t n = 0; n < observed_keypoints_.size(); ++n) {
    const int keypoint = observed_keypoints_[n];
    if (outliers_[n]) {
      matches_[keypoint] = -1;
      depth_matches_[keypoint].reset();
    } else {
      ++map_inliers;
    }
  }
  times_.optimize_ms += stopwatch.LapMs();
  return map_inliers;
}

}  // namespace semmap
