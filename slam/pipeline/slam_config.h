#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "slam/common/fwd.h"
#include "slam/features/orb_extractor.h"
#include "slam/features/stereo_matcher.h"
#include "slam/pipeline/agreement.h"
#include "slam/place/place_config.h"
#include "slam/semantics/segmentation_config.h"
#include "slam/semantics/semantics_config.h"

namespace semmap {

struct TrackingConfig {
  // Matched points with which a frame counts as tracked at all, and with which a local map match is good.
  int min_inliers = 15;
  int min_inliers_map = 30;
  // Inliers among the points that should be in sight: below the first share a frame does not count as
  // tracked, below the second the place is looked for elsewhere, too.
  double min_inlier_share = 0.1;
  double doubtful_inlier_share = 0.25;
  // The second, of points that are near (close_depth_in_baselines), which alone tell where the camera is.
  double doubtful_near_share = 0.15;
  // Depth is trusted for scale up to this many baselines.
  double close_depth_in_baselines = 40;
  // A keyframe is made at the latest, and at the earliest (unless urgent), after these times if tracking
  // weakens.
  double max_keyframe_interval_s = 1.0;
  double min_keyframe_interval_s = 0.0;
  // Tracking is weak below this share of the reference keyframe's points: one eye (points seen twice), and
  // with depth (all its points, of which many were only ever seen by it).
  double keyframe_ratio = 0.6;
  double keyframe_ratio_depth = 0.5;

  void Read(ConfigReader& reader);
};

struct MappingConfig {
  // Local bundle adjustment: free keyframes, and fixed ones on the rim.
  int max_local_keyframes = 20;
  int max_fixed_keyframes = 30;
  // Covisible keyframes with which new points are triangulated: one eye, and with depth.
  int neighbours_to_triangulate = 10;
  int neighbours_to_triangulate_depth = 10;
  // A keyframe is culled when this share of its points is seen by three others at least as well.
  double cull_redundancy = 0.9;
  // Keyframes that may wait for the mapper.
  int queue = 3;
  int bundle_iterations = 5;
  int bundle_iterations_refined = 10;

  void Read(ConfigReader& reader);
};

struct RelocalizationConfig {
  // Keyframes tried, those that look most alike first; and how many of them once more with all descriptors
  // instead of those of equal vocabulary nodes.
  int candidates = 10;
  int exhaustive_candidates = 3;
  // Points that must agree with the pose.
  AgreementLimits limits;
  // Where a vehicle is looked for that was not there a moment ago (Relocalize, sessions in stored maps): how
  // uncertain its position may be, one standard deviation as a share of the depth of what it sees; and how
  // many of the best place's inliers another place may have.
  double max_uncertainty = 0.02;
  double max_rival_share = 0.6;

  void Read(ConfigReader& reader);
};

struct LoopConfig {
  bool enabled = true;
  // Keyframes tried, those that look most alike first. They must reach this share of the similarity that the
  // keyframe has with the least similar of its neighbours.
  int candidates = 10;
  double min_score_share = 1.0;
  // How many keyframes in a row must resemble one group.
  int consistency = 3;
  // Points that must agree, of the new image in the old surroundings and the other way round.
  int min_inliers = 50;
  int min_reverse_inliers = 40;
  double min_inlier_share = 0.1;  // of the points that should be in sight
  // Keyframes between two loops.
  int min_interval = 10;
  // Keyframes that share so many points are tied in the pose graph besides the spanning tree.
  int pose_graph_min_shared = 100;
  int pose_graph_iterations = 30;
  // Bundle adjustment of the whole map afterwards, in the background.
  bool full_adjustment = true;
  int full_iterations = 10;

  void Read(ConfigReader& reader);
};

// How two stored maps are found to show common places.
struct MergeConfig {
  // Places tried for each keyframe, those that look most alike first.
  int candidates = 5;
  // Keyframes that must be found in the other map, all telling one similarity between the maps; and how many
  // of these another similarity may have.
  int min_keyframes = 3;
  double max_rival_share = 0.5;

  void Read(ConfigReader& reader);
};

// Everything of a session that can be configured, with defaults. YAML keys are the member names.
struct SlamConfig {
  // Of more corners the weaker ones are located worse, and cost as much.
  OrbConfig orb = {.features = 1500};
  StereoConfig stereo;
  TrackingConfig tracking;
  MappingConfig mapping;
  PlaceConfig place;
  RelocalizationConfig relocalization;
  LoopConfig loop;
  MergeConfig merge;
  SegmentationConfig segmentation;
  SemanticsConfig semantics;
  // Everything of a session runs in the thread that brings the frames: same input, same bytes.
  bool deterministic = false;
  int64_t seed = 1;

  void Read(ConfigReader& reader);
  // The `slam` section of a file; its other sections are ignored.
  static absl::StatusOr<SlamConfig> FromFile(const std::string& path);
};

}  // namespace semmap
