// The part of Tracker that finds the pose of a frame: from the last frame, from a keyframe, in the local map.
#include <algorithm>

#include "slam/pipeline/keyframe_matcher.h"
#include "slam/pipeline/stopwatch.h"
#include "slam/pipeline/tracker.h"

namespace semmap {
namespace {

constexpr int kMinMatches = 20;
constexpr int kMinInliers = 10;
// Search windows in pixels of octave 0.
constexpr float kMotionRadius = 12;
constexpr float kMotionRadiusDepth = 8;
// Depth anchors: as many of the nearest, or all that are close.
constexpr size_t kMinDepthAnchors = 100;

}  // namespace

bool Tracker::FollowLastFrame(TrackedFrame* frame) {
  if (state_ == TrackingState::kLost || !last_) return false;
  Stopwatch stopwatch;
  const double optimize_before = times_.optimize_ms;
  bool found = TrackFromLastFrame(frame);
  if (!found) {
    frame->camera_from_map = last_->camera_from_map;
    found = TrackFromKeyFrame(view_->reference(), frame);
  }
  times_.match_ms += stopwatch.LapMs() - (times_.optimize_ms - optimize_before);
  return found;
}

bool Tracker::Locate(TrackedFrame* frame, FrameResult* result) {
  relocalized_ = false;
  agreement_ = Agreement();
  const bool found = FollowLastFrame(frame) && TrackLocalMap(frame, result);
  if (found && !IsDoubtful(agreement_)) return true;
  // Far points alone fit a pose that is metres off. What the near keyframes say counts if more agrees with
  // it.
  Stopwatch stopwatch;
  std::optional<ViewFix> nearby = FindNearby(*frame);
  times_.match_ms += stopwatch.LapMs();
  if (!nearby || (found && nearby->agreement.Trust() <= agreement_.Trust())) return found;
  relocalized_ = true;
  frame->camera_from_map = nearby->camera_from_map;
  matches_ = std::move(nearby->matches);
  return TrackLocalMap(frame, result);
}

bool Tracker::IsDoubtful(const Agreement& agreement) const {
  return agreement.Share() < config_.tracking.doubtful_inlier_share ||
         agreement.NearShare() < config_.tracking.doubtful_near_share;
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
    } else if (MeasuresDepth(keypoints[i])) {
      by_depth.emplace_back(keypoints[i].depth, static_cast<int>(i));
    }
  }
  std::sort(by_depth.begin(), by_depth.end());
  const SE3 map_from_last = last_->camera_from_map.Inverse();
  for (size_t n = 0; n < by_depth.size(); ++n) {
    const auto& [depth, keypoint] = by_depth[n];
    if (n >= kMinDepthAnchors && depth > camera_.near_depth) break;
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
    const WindowQuery query{
        x,
        y,
        radius * builder_.scale_info().scales[seen.octave],
        seen.octave - 1,
        seen.octave + 1,
        shift > 0 ? static_cast<float>(pixel.x() - shift) : -1.0F,
        &last.descriptors[anchors[i].keypoint],
        anchors[i].view_index >= 0 ? view_->classes[anchors[i].view_index] : seen.semantic_class};
    const WindowMatch match = FindInWindow(search_.association, image, query, [](int) { return true; });
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

bool Tracker::TrackFromKeyFrame(const ViewKeyFrame& keyframe, TrackedFrame* frame) {
  const std::vector<KeypointPair> pairs =
      MatchExhaustively(camera_.association, *view_, keyframe, *frame->features);
  if (pairs.size() < kMinInliers) return false;
  std::fill(matches_.begin(), matches_.end(), -1);
  std::fill(depth_matches_.begin(), depth_matches_.end(), std::nullopt);
  for (const KeypointPair& pair : pairs) matches_[pair.second] = keyframe.point_of_keypoint[pair.first];
  Matrix6d covariance;
  return OptimizeFrame(frame, &covariance) >= kMinMatches;
}

std::optional<ViewFix> Tracker::FindNearby(const TrackedFrame& frame) const {
  ViewLocalizerOptions options;
  options.limits = config_.relocalization.limits;
  options.seed = static_cast<uint32_t>(config_.seed);
  std::optional<ViewFix> best;
  for (const ViewKeyFrame& keyframe : view_->keyframes) {
    ViewLocalization located =
        LocateInView(options, camera_, builder_.scale_info(), *view_, keyframe,
                     MatchExhaustively(camera_.association, *view_, keyframe, *frame.features),
                     {*frame.features, *frame.grid});
    if (!located.fix) continue;
    if (!best || located.fix->agreement.Trust() > best->agreement.Trust()) best = std::move(located.fix);
    if (!IsDoubtful(best->agreement)) break;
  }
  return best;
}

// --- in the local map

bool Tracker::TrackLocalMap(TrackedFrame* frame, FrameResult* result) {
  Stopwatch stopwatch;
  // Depth anchors are one noisy measurement each; from here on the map's points say more.
  std::fill(depth_matches_.begin(), depth_matches_.end(), std::nullopt);
  agreement_ = MatchLocalMap(*view_, frame->camera_from_map, {*frame->features, *frame->grid}, search_,
                             &counters_, &matches_);
  times_.match_ms += stopwatch.LapMs();
  result->inliers = OptimizeFrame(frame, &result->covariance);
  CountInliers(*view_, frame->camera_from_map, camera_.near_depth, matches_, &agreement_);
  return result->inliers >= config_.tracking.min_inliers_map &&
         agreement_.Share() >= config_.tracking.min_inlier_share;
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
