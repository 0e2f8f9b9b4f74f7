#include "slam/pipeline/slam_config.h"

#include "slam/common/config_reader.h"
#include "slam/common/status_macros.h"

namespace semmap {

void TrackingConfig::Read(ConfigReader& reader) {
  reader.Number("min_inliers", &min_inliers, 6, 1000);
  reader.Number("min_inliers_map", &min_inliers_map, 6, 1000);
  reader.Number("min_inlier_share", &min_inlier_share, 0.0, 1.0);
  reader.Number("doubtful_inlier_share", &doubtful_inlier_share, 0.0, 1.0);
  reader.Number("doubtful_near_share", &doubtful_near_share, 0.0, 1.0);
  reader.Number("close_depth_in_baselines", &close_depth_in_baselines, 1.0, 1000.0);
  reader.Number("max_keyframe_interval_s", &max_keyframe_interval_s, 0.0, 60.0);
  reader.Number("min_keyframe_interval_s", &min_keyframe_interval_s, 0.0, 60.0);
  reader.Number("keyframe_ratio", &keyframe_ratio, 0.1, 1.0);
  reader.Number("keyframe_ratio_depth", &keyframe_ratio_depth, 0.1, 1.0);
  if (min_keyframe_interval_s > max_keyframe_interval_s) {
    reader.Complain("min_keyframe_interval_s", "is greater than max_keyframe_interval_s");
  }
}

void MappingConfig::Read(ConfigReader& reader) {
  reader.Number("max_local_keyframes", &max_local_keyframes, 2, 200);
  reader.Number("max_fixed_keyframes", &max_fixed_keyframes, 2, 400);
  reader.Number("neighbours_to_triangulate", &neighbours_to_triangulate, 1, 100);
  reader.Number("neighbours_to_triangulate_depth", &neighbours_to_triangulate_depth, 1, 100);
  reader.Number("cull_redundancy", &cull_redundancy, 0.5, 1.0);
  reader.Number("queue", &queue, 1, 100);
  reader.Number("bundle_iterations", &bundle_iterations, 1, 100);
  reader.Number("bundle_iterations_refined", &bundle_iterations_refined, 0, 100);
}

void RelocalizationConfig::Read(ConfigReader& reader) {
  reader.Number("candidates", &candidates, 1, 1000);
  reader.Number("exhaustive_candidates", &exhaustive_candidates, 0, 1000);
  reader.Number("min_inliers", &limits.min_inliers, 10, 10000);
  reader.Number("min_inlier_share", &limits.min_inlier_share, 0.0, 1.0);
  reader.Number("min_near_share", &limits.min_near_share, 0.0, 1.0);
  reader.Number("max_uncertainty", &max_uncertainty, 0.0, 1000.0);
  reader.Number("max_rival_share", &max_rival_share, 0.0, 1.0);
}

void LoopConfig::Read(ConfigReader& reader) {
  reader.Flag("enabled", &enabled);
  reader.Number("candidates", &candidates, 1, 1000);
  reader.Number("min_score_share", &min_score_share, 0.0, 1.0);
  reader.Number("consistency", &consistency, 1, 100);
  reader.Number("min_inliers", &min_inliers, 10, 10000);
  reader.Number("min_inlier_share", &min_inlier_share, 0.0, 1.0);
  reader.Number("min_reverse_inliers", &min_reverse_inliers, 10, 10000);
  reader.Number("min_interval", &min_interval, 0, 10000);
  reader.Number("pose_graph_min_shared", &pose_graph_min_shared, 1, 100000);
  reader.Number("pose_graph_iterations", &pose_graph_iterations, 1, 1000);
  reader.Flag("full_adjustment", &full_adjustment);
  reader.Number("full_iterations", &full_iterations, 1, 1000);
}

void MergeConfig::Read(ConfigReader& reader) {
  reader.Number("candidates", &candidates, 1, 1000);
  reader.Number("min_keyframes", &min_keyframes, 2, 10000);
  reader.Number("max_rival_share", &max_rival_share, 0.0, 1.0);
}

void SlamConfig::Read(ConfigReader& reader) {
  reader.Section("orb", &orb);
  reader.Section("stereo", &stereo);
  reader.Section("tracking", &tracking);
  reader.Section("mapping", &mapping);
  reader.Section("place", &place);
  reader.Section("relocalization", &relocalization);
  reader.Section("loop", &loop);
  reader.Section("merge", &merge);
  reader.Section("segmentation", &segmentation);
  reader.Section("semantics", &semantics);
  reader.Flag("deterministic", &deterministic);
  reader.Number("seed", &seed, 0, INT64_C(4294967295));
}

absl::StatusOr<SlamConfig> SlamConfig::FromFile(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(ConfigReader reader, ConfigReader::FromFile(path));
  SlamConfig config;
  reader.Section("slam", &config);
  reader.Ignore("server");
  reader.Ignore("storage");
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return config;
}

}  // namespace semmap
