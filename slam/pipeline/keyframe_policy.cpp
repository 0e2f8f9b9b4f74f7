#include "slam/pipeline/keyframe_policy.h"

namespace semmap {
namespace {

constexpr int kEnoughClosePoints = 100;
constexpr int kWorthwhileClosePoints = 70;
// A young map is not yet dense enough to ask for most of the reference's points.
constexpr double kYoungMapRatio = 0.4;
constexpr double kUrgentRatio = 0.3;

double ReferenceRatio(const TrackingConfig& config, const KeyFrameEvidence& evidence) {
  if (evidence.sensor == SensorType::kMono) return config.keyframe_ratio;
  return evidence.map_keyframes < 2 ? kYoungMapRatio : config.keyframe_ratio_depth;
}

}  // namespace

bool IsKeyFrameNeeded(const TrackingConfig& config, const KeyFrameEvidence& evidence) {
  if (!evidence.mapper_accepts || evidence.inliers <= config.min_inliers) return false;
  const bool needs_close_points = evidence.sensor != SensorType::kMono &&
                                  evidence.close_tracked < kEnoughClosePoints &&
                                  evidence.close_untracked > kWorthwhileClosePoints;
  const double share = static_cast<double>(evidence.inliers) / (evidence.reference_points + 1);
  if (share >= ReferenceRatio(config, evidence) && !needs_close_points) return false;
  const bool urgent = needs_close_points || share < kUrgentRatio;
  const bool due = evidence.seconds_since_keyframe >= config.max_keyframe_interval_s;
  const bool convenient =
      evidence.mapper_idle && evidence.seconds_since_keyframe >= config.min_keyframe_interval_s;
  return urgent || due || convenient;
}

}  // namespace semmap
