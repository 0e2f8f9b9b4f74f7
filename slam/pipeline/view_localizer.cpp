#include "slam/pipeline/view_localizer.h"

#include <algorithm>

#include "slam/geometry/pnp.h"
#include "slam/optimize/pose_optimizer.h"

namespace semmap {
namespace {

// Search windows in pixels of octave 0: around a rough pose, and around a good one.
constexpr float kRoughRadius = 10;
constexpr float kGoodRadius = 4;

// One image on its way through the stages.
class Localizer {
 public:
  Localizer(const MappingCamera& camera, const ScalePyramidInfo& scale_info, const LocalMapView& view,
            const SearchImage& image)
      : camera_(camera), scale_info_(scale_info), view_(&view), image_(image) {
    fix_.matches.assign(image.features.size(), -1);
  }

  bool FindPose(const ViewKeyFrame& keyframe, const std::vector<KeypointPair>& pairs,
                const ViewLocalizerOptions& options) {
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> pixels;
    for (const KeypointPair& pair : pairs) {
      points.push_back(view_->positions[keyframe.point_of_keypoint[pair.first]]);
      const Keypoint& keypoint = image_.features.keypoints[pair.second];
      pixels.emplace_back(keypoint.x, keypoint.y);
    }
    PnpOptions pnp;
    pnp.seed = options.seed;
    pnp.min_inliers = options.min_pose_inliers;
    const auto pose = EstimatePose(camera_.rig.camera, points, pixels, pnp);
    if (!pose) return false;
    fix_.camera_from_map = pose->camera_from_map;
    for (size_t i = 0; i < pairs.size(); ++i) {
      if (pose->inlier[i]) fix_.matches[pairs[i].second] = keyframe.point_of_keypoint[pairs[i].first];
    }
    Refine();
    return fix_.agreement.inliers >= options.min_pose_inliers;
  }

  void SearchAround(float radius) {
    ProjectionSearch search;
    search.model = camera_.model;
    search.bounds = camera_.bounds;
    search.scale_info = &scale_info_;
    search.radius = radius;
    search.near_depth = camera_.near_depth;
    search.association = camera_.association;
    SightingCounters counters;
    counters.visible.assign(view_->size(), 0);
    fix_.agreement = MatchLocalMap(*view_, fix_.camera_from_map, image_, search, &counters, &fix_.matches);
    Refine();
  }

  // A view that begins with the points of the last one.
  void LookIn(const LocalMapView& view) { view_ = &view; }

  void StartAt(const SE3& camera_from_map) { fix_.camera_from_map = camera_from_map; }

  ViewLocalization Judge(const ViewLocalizerOptions& options) const {
    ViewLocalization result;
    result.agreement = fix_.agreement;
    if (options.limits.Admit(fix_.agreement)) {
      result.fix = fix_;
    } else {
      result.failure = LocalizationFailure::kTooFewInliers;
    }
    return result;
  }

 private:
  void Refine() {
    std::vector<PoseObservation> observations;
    std::vector<size_t> keypoints;
    for (size_t i = 0; i < fix_.matches.size(); ++i) {
      if (fix_.matches[i] < 0) continue;
      const Keypoint& keypoint = image_.features.keypoints[i];
      observations.push_back(
          {view_->positions[fix_.matches[i]],
           {keypoint.x, keypoint.y, keypoint.right_x, scale_info_.inverse_sigma2[keypoint.octave]}});
      keypoints.push_back(i);
    }
    std::vector<char> outliers;
    const PoseEstimate estimate = OptimizePose(camera_.model, fix_.camera_from_map, observations, &outliers);
    for (size_t n = 0; n < keypoints.size(); ++n) {
      if (outliers[n]) fix_.matches[keypoints[n]] = -1;
    }
    fix_.camera_from_map = estimate.camera_from_map;
    fix_.covariance = estimate.covariance;
    fix_.agreement.inliers = fix_.agreement.near_inliers = 0;
    CountInliers(*view_, fix_.camera_from_map, camera_.near_depth, fix_.matches, &fix_.agreement);
  }

  const MappingCamera& camera_;
  const ScalePyramidInfo& scale_info_;
  const LocalMapView* view_;
  const SearchImage& image_;
  ViewFix fix_;
};

ViewLocalization Locate(const ViewLocalizerOptions& options, const MappingCamera& camera,
                        const ScalePyramidInfo& scale_info, const LocalMapView& view,
                        const ViewKeyFrame& keyframe, const std::vector<KeypointPair>& pairs,
                        const SearchImage& image, absl::FunctionRef<const LocalMapView*()> surroundings) {
  ViewLocalization result;
  result.matches = static_cast<int>(pairs.size());
  if (result.matches < options.min_matches) {
    result.failure = LocalizationFailure::kTooFewMatches;
    return result;
  }
  Localizer localizer(camera, scale_info, view, image);
  const LocalMapView* around = localizer.FindPose(keyframe, pairs, options) ? surroundings() : nullptr;
  if (around == nullptr) {
    result.failure = LocalizationFailure::kDegeneratePose;
    return result;
  }
  localizer.LookIn(*around);
  localizer.SearchAround(kRoughRadius);
  localizer.SearchAround(kGoodRadius);
  ViewLocalization judged = localizer.Judge(options);
  judged.matches = result.matches;
  return judged;
}

}  // namespace

ViewLocalization LocateInView(const ViewLocalizerOptions& options, const MappingCamera& camera,
                              const ScalePyramidInfo& scale_info, const LocalMapView& view,
                              const ViewKeyFrame& keyframe, const std::vector<KeypointPair>& pairs,
                              const SearchImage& image) {
  return Locate(options, camera, scale_info, view, keyframe, pairs, image, [&] { return &view; });
}

ViewLocalization LocateInView(const ViewLocalizerOptions& options, const MappingCamera& camera,
                              const ScalePyramidInfo& scale_info, const LocalMapView& own,
                              const std::vector<KeypointPair>& pairs, const SearchImage& image,
                              absl::FunctionRef<const LocalMapView*()> surroundings) {
  return Locate(options, camera, scale_info, own, own.reference(), pairs, image, surroundings);
}

ViewLocalization LocateNear(const ViewLocalizerOptions& options, const MappingCamera& camera,
                            const ScalePyramidInfo& scale_info, const LocalMapView& view,
                            const SE3& camera_from_map, const SearchImage& image) {
  Localizer localizer(camera, scale_info, view, image);
  localizer.StartAt(camera_from_map);
  localizer.SearchAround(kGoodRadius);
  localizer.SearchAround(kGoodRadius);
  return localizer.Judge(options);
}

}  // namespace semmap
