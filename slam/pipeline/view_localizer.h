#pragma once

#include <optional>
#include <vector>

#include "absl/functional/function_ref.h"
#include "slam/geometry/se3.h"
#include "slam/map/local_map_view.h"
#include "slam/pipeline/agreement.h"
#include "slam/pipeline/association.h"
#include "slam/pipeline/local_map_matcher.h"
#include "slam/pipeline/localization_failure.h"
#include "slam/pipeline/mapping_camera.h"

namespace semmap {

// Where a camera is among the points of a view, and which of them its keypoints see.
struct ViewFix {
  SE3 camera_from_map;
  Matrix6d covariance = Matrix6d::Zero();  // as PoseEstimate::covariance
  Agreement agreement;
  ViewMatches matches;
};

struct ViewLocalization {
  std::optional<ViewFix> fix;
  LocalizationFailure failure = LocalizationFailure::kNone;
  int matches = 0;      // pairs it began with
  Agreement agreement;  // of the last stage reached
};

struct ViewLocalizerOptions {
  int min_matches = 15;
  int min_pose_inliers = 10;
  AgreementLimits limits;
  uint32_t seed = 1;
};

// Finds the pose of an image from pairs of a keyframe's keypoints (first; one of the view, all of these see a
// point) with its own (second): RANSAC over three pairs, then guided search over all points of the view and
// refinement, twice, and acceptance by inliers (Mur-Artal et al. 2015, section V-D). Thread-safe,
// deterministic.
ViewLocalization LocateInView(const ViewLocalizerOptions& options, const MappingCamera& camera,
                              const ScalePyramidInfo& scale_info, const LocalMapView& view,
                              const ViewKeyFrame& keyframe, const std::vector<KeypointPair>& pairs,
                              const SearchImage& image);

// The same where at first only the keyframe and its own points are at hand, as the view `own`: `surroundings`
// is asked once, when these give a pose, for a view that begins with the same points, or nullptr to give up.
ViewLocalization LocateInView(const ViewLocalizerOptions& options, const MappingCamera& camera,
                              const ScalePyramidInfo& scale_info, const LocalMapView& own,
                              const std::vector<KeypointPair>& pairs, const SearchImage& image,
                              absl::FunctionRef<const LocalMapView*()> surroundings);

// The same for an image whose pose is known but for a few pixels: guided search and refinement alone.
ViewLocalization LocateNear(const ViewLocalizerOptions& options, const MappingCamera& camera,
                            const ScalePyramidInfo& scale_info, const LocalMapView& view,
                            const SE3& camera_from_map, const SearchImage& image);

}  // namespace semmap
