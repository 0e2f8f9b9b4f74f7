#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "slam/features/orb_extractor.h"
#include "slam/features/stereo_matcher.h"

namespace semmap {

struct TrackingConfig {
  int min_inliers = 15;                  // fewer: the frame is lost
  int min_inliers_map = 30;              // of the local map, for a good frame
  double close_depth_in_baselines = 40;  // depth points nearer than this are trusted for scale
  double max_keyframe_interval_s = 1.0;
  double keyframe_ratio = 0.9;           // of the reference keyframe's points still tracked; below: new keyframe

  void Read(ConfigReader& reader);
};

struct MappingConfig {
  int max_local_keyframes = 20;   // free in local bundle adjustment
  int max_fixed_keyframes = 30;   // on its rim
  int neighbours_to_triangulate = 10;
  double cull_redundancy = 0.9;   // a keyframe this redundant is culled
  int queue = 3;                  // keyframes that may wait for the mapper

  void Read(ConfigReader& reader);
};

// Everything of a session that can be configured, with defaults. YAML keys are the member names.
struct SlamConfig {
  OrbConfig orb;
  StereoConfig stereo;
  TrackingConfig tracking;
  MappingConfig mapping;
  // Everything of a session runs in the thread that brings the frames: same input, same bytes.
  bool deterministic = false;
  int64_t seed = 1;

  void Read(ConfigReader& reader);
  // The `slam` section of a file; its other sections are ignored.
  static absl::StatusOr<SlamConfig> FromFile(const std::string& path);
};

}  // namespace semmap
