#include "client/cli/map_rework_report.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_format.h"
#include "client/cli/map_report.h"
#include "client/names.h"

namespace semmap::client {
namespace {

using Json = nlohmann::json;

Json SimilarityJson(const v1::Similarity& similarity) {
  const v1::Vector3& t = similarity.pose().translation();
  const v1::Quaternion& q = similarity.pose().rotation();
  return {{"scale", similarity.scale()},
          {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
          {"translation", {t.x(), t.y(), t.z()}}};
}

double AngleDegrees(const v1::Quaternion& q) {
  return 2 * std::acos(std::min(1.0, std::abs(q.w()))) * 180 / std::numbers::pi;
}

}  // namespace

Json MergeJson(const v1::MergeMapsResponse& response, bool dry_run) {
  return {{"dry_run", dry_run},
          {"map", MapJson(response.map())},
          {"target_from_source", SimilarityJson(response.target_from_source())},
          {"overlapping_keyframes", response.overlapping_keyframes()},
          {"fused_points", response.fused_points()},
          {"reprojection_rms_px", response.reprojection_rms_px()}};
}

std::string MergeTable(const v1::MergeMapsResponse& response, bool dry_run) {
  const v1::Similarity& similarity = response.target_from_source();
  const v1::Vector3& t = similarity.pose().translation();
  return absl::StrFormat(
      "overlap     %d keyframes\n"
      "moved by    %.3f %.3f %.3f, turned by %.2f degrees, scaled by %.5f\n"
      "fused       %d points\n"
      "residual    %.2f px RMS%s\n"
      "%s       %s, %d keyframes, %d points\n",
      response.overlapping_keyframes(), t.x(), t.y(), t.z(), AngleDegrees(similarity.pose().rotation()),
      similarity.scale(), response.fused_points(), response.reprojection_rms_px(),
      dry_run ? " before adjustment" : "", dry_run ? "stays" : "holds", IdOfName(response.map().name()),
      response.map().keyframe_count(), response.map().point_count());
}

Json OptimizeJson(const Client::Optimized& optimized) {
  const v1::OptimizeReport& report = optimized.report;
  return {{"map", MapJson(optimized.map)},
          {"initial_rms_px", report.initial_rms_px()},
          {"final_rms_px", report.final_rms_px()},
          {"iterations", report.iterations()},
          {"removed_observations", report.removed_observations()}};
}

std::string OptimizeTable(const Client::Optimized& optimized) {
  const v1::OptimizeReport& report = optimized.report;
  return absl::StrFormat(
      "residual    %.3f px RMS, was %.3f\n"
      "iterations  %d\n"
      "removed     %d observations\n"
      "holds       %s, %d keyframes, %d points\n",
      report.final_rms_px(), report.initial_rms_px(), report.iterations(), report.removed_observations(),
      IdOfName(optimized.map.name()), optimized.map.keyframe_count(), optimized.map.point_count());
}

Json PruneJson(const Client::Pruned& pruned, bool dry_run) {
  return {{"dry_run", dry_run},
          {"map", MapJson(pruned.map)},
          {"removed_keyframes", pruned.report.removed_keyframes()},
          {"removed_points", pruned.report.removed_points()}};
}

std::string PruneTable(const Client::Pruned& pruned, bool dry_run) {
  return absl::StrFormat(
      "%s     %d keyframes, %d points\n"
      "%s       %s, %d keyframes, %d points\n",
      dry_run ? "removes" : "removed", pruned.report.removed_keyframes(), pruned.report.removed_points(),
      dry_run ? "keeps" : "holds", IdOfName(pruned.map.name()), pruned.map.keyframe_count(),
      pruned.map.point_count());
}

}  // namespace semmap::client
