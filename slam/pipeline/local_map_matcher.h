#pragma once

#include <cstdint>
#include <vector>

#include "slam/geometry/camera.h"
#include "slam/map/local_map_view.h"
#include "slam/optimize/observation.h"
#include "slam/pipeline/agreement.h"
#include "slam/pipeline/association.h"

namespace semmap {

// For each keypoint of a frame the index of the view's point that it sees, or -1.
using ViewMatches = std::vector<int32_t>;

// How often each point of a view was expected and found since the counters were last reported.
struct SightingCounters {
  std::vector<uint16_t> visible;
  std::vector<uint16_t> found;
};

struct ProjectionSearch {
  ProjectionModel model;
  ImageBounds bounds;
  const ScalePyramidInfo* scale_info = nullptr;
  float radius = 3;  // pixels at octave 0, at a good prediction
  double distinct_ratio = 0.8;
  // Points up to this depth tell where the camera is; 0: none is known to.
  double near_depth = 0;
  AssociationRule association = {};
};

// Projects every point of the view that `matches` does not hold yet, and pairs it with the best free keypoint
// near its projection. Points must face the camera (within 60 degrees of the mean viewing direction) and be
// at a distance at which their corner exists on the pyramid. Counts expected points in `counters`, and
// in the result, those matched before included; what is an inlier is CountInliers' to say, after the pose was
// refined.
Agreement MatchLocalMap(const LocalMapView& view, const SE3& camera_from_map, const SearchImage& image,
                        const ProjectionSearch& search, SightingCounters* counters, ViewMatches* matches);

// Counts the matches, all of them inliers now, in `agreement`.
void CountInliers(const LocalMapView& view, const SE3& camera_from_map, double near_depth,
                  const ViewMatches& matches, Agreement* agreement);

// The pyramid level at which a corner with this greatest distance appears from `distance`.
int PredictOctave(float max_distance, float distance, const ScalePyramidInfo& scale_info);

}  // namespace semmap
