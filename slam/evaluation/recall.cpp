#include "slam/evaluation/recall.h"

#include <algorithm>

namespace semmap {

PoseError ComparePoses(const SE3& reference_map_from_camera, const SE3& estimate_map_from_camera) {
  const SE3 difference = reference_map_from_camera.Inverse() * estimate_map_from_camera;
  return {difference.translation().norm(), difference.RotationAngle()};
}

std::vector<double> RecallAtThresholds(std::span<const PoseError> errors, size_t queries,
                                       std::span<const PoseThreshold> thresholds) {
  const double total = static_cast<double>(std::max(queries, errors.size()));
  std::vector<double> recalls;
  for (const PoseThreshold& threshold : thresholds) {
    const auto hits = std::count_if(errors.begin(), errors.end(), [&threshold](const PoseError& error) {
      return error.translation_m <= threshold.translation_m && error.rotation_rad <= threshold.rotation_rad;
    });
    recalls.push_back(total > 0 ? static_cast<double>(hits) / total : 0.0);
  }
  return recalls;
}

}  // namespace semmap
