#include "slam/pipeline/loop_verifier.h"

#include <algorithm>
#include <cmath>

#include "slam/pipeline/keyframe_matcher.h"
#include "slam/pipeline/view_localizer.h"

namespace semmap {
namespace {

// Fewer common points tell too little of the scale.
constexpr size_t kMinScalePairs = 10;
// How far the two poses may disagree: radians, and shares of the median depth of what is seen.
constexpr double kMaxTurn = 0.05;
constexpr double kMaxShift = 0.1;
// Where depth is measured, maps may not differ in scale by more.
constexpr double kMaxMeasuredScaleError = 0.1;

// One keyframe's image in the surroundings of the other.
struct CrossLook {
  std::shared_ptr<const LocalMapView> view;
  ViewFix fix;
  // Depths of what the image sees, in units of its own map and of the other, for points known to both.
  std::vector<std::pair<double, double>> depths;
};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void CompareDepths(const Map& map, const KeyFrame& image, CrossLook* look) {
  for (size_t i = 0; i < image.points.size(); ++i) {
    const MapPoint* point = look->fix.matches[i] >= 0 ? map.FindActivePoint(image.points[i]) : nullptr;
    if (point == nullptr) continue;
    const double own = (image.camera_from_map * point->position_in_map).z();
    const double other = (look->fix.camera_from_map * look->view->positions[look->fix.matches[i]]).z();
    if (own > 0 && other > 0) look->depths.emplace_back(own, other);
  }
}

std::optional<CrossLook> LookAcross(const ViewLocalizerOptions& options, const MappingCamera& camera,
                                    const PlaceMemory& places, const Map& map, KeyFrameId place_id,
                                    KeyFrameId image_id) {
  const KeyFrame& image = *map.FindKeyFrame(image_id);
  const DirectIndex* place_nodes = places.NodesOf(place_id);
  const DirectIndex* image_nodes = places.NodesOf(image_id);
  if (place_nodes == nullptr || image_nodes == nullptr) return std::nullopt;
  const auto pairs = MatchWithinNodes(camera.association, map, *map.FindKeyFrame(place_id), *place_nodes,
                                      *image.features, *image_nodes);
  if (static_cast<int>(pairs.size()) < options.min_matches) return std::nullopt;
  CrossLook look;
  look.view = MakeLocalMapView(map, place_id, 0, LocalMapViewLimits());
  const ViewLocalization located =
      LocateInView(options, camera, map.scale_info(), *look.view, look.view->reference(), pairs,
                   {*image.features, *image.grid});
  if (!located.fix) return std::nullopt;
  look.fix = *located.fix;
  CompareDepths(map, image, &look);
  return look;
}

// Units around `old` for one unit around `current`.
std::optional<double> RelativeScale(const CrossLook& current_in_old, const CrossLook& old_in_current) {
  std::vector<double> ratios;
  for (const auto& [own, other] : current_in_old.depths) ratios.push_back(other / own);
  for (const auto& [own, other] : old_in_current.depths) ratios.push_back(own / other);
  if (ratios.size() < kMinScalePairs) return std::nullopt;
  return Median(std::move(ratios));
}

bool AgreesWith(const SE3& a, const SE3& b, double depth) {
  const SE3 difference = a.Inverse() * b;
  return difference.RotationAngle() < kMaxTurn && difference.translation().norm() < kMaxShift * depth;
}

double MedianDepth(const CrossLook& look) {
  std::vector<double> depths;
  for (const auto& [own, other] : look.depths) depths.push_back(other);
  return Median(std::move(depths));
}

}  // namespace

std::optional<Loop> VerifyLoop(const LoopConfig& config, uint32_t seed, const MappingCamera& camera,
                               const PlaceMemory& places, const Map& map, KeyFrameId old_id,
                               KeyFrameId current_id) {
  ViewLocalizerOptions options;
  options.seed = seed;
  options.limits.min_inliers = config.min_inliers;
  options.limits.min_inlier_share = config.min_inlier_share;
  const auto forth = LookAcross(options, camera, places, map, old_id, current_id);
  if (!forth) return std::nullopt;
  options.limits.min_inliers = config.min_reverse_inliers;
  const auto back = LookAcross(options, camera, places, map, current_id, old_id);
  if (!back) return std::nullopt;
  auto scale = RelativeScale(*forth, *back);
  if (!scale || forth->depths.empty()) return std::nullopt;
  if (camera.HasDepth()) {
    if (std::abs(*scale - 1) > kMaxMeasuredScaleError) return std::nullopt;
    scale = 1.0;
  }
  const KeyFrame& old = *map.FindKeyFrame(old_id);
  const KeyFrame& current = *map.FindKeyFrame(current_id);
  const SE3 old_from_current = old.camera_from_map * forth->fix.camera_from_map.Inverse();
  // The other look gives the same in units around `current`.
  SE3 reverse = back->fix.camera_from_map * current.camera_from_map.Inverse();
  reverse = SE3(reverse.rotation(), *scale * reverse.translation());
  if (!AgreesWith(old_from_current, reverse, MedianDepth(*forth))) return std::nullopt;
  Loop loop{old_id,
            current_id,
            {*scale, old_from_current},
            {},
            forth->fix.agreement.inliers,
            back->fix.agreement.inliers};
  for (size_t i = 0; i < forth->fix.matches.size(); ++i) {
    if (forth->fix.matches[i] >= 0)
      loop.seen.emplace_back(forth->view->ids[forth->fix.matches[i]], static_cast<uint32_t>(i));
  }
  return loop;
}

}  // namespace semmap
