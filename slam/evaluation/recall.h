#pragma once

#include <array>
#include <numbers>
#include <span>
#include <vector>

#include "slam/geometry/se3.h"

namespace semmap {

// How far one answered localization query was off.
struct PoseError {
  double translation_m = 0;
  double rotation_rad = 0;
};

// Distance between the camera centres and angle between the orientations.
PoseError ComparePoses(const SE3& reference_map_from_camera, const SE3& estimate_map_from_camera);

struct PoseThreshold {
  double translation_m = 0;
  double rotation_rad = 0;
};

// High, medium and coarse precision of Sattler et al. 2018, "Benchmarking 6DOF Outdoor Visual Localization in
// Changing Conditions": 0.25 m and 2 degrees, 0.5 m and 5 degrees, 5 m and 10 degrees.
constexpr std::array<PoseThreshold, 3> kLocalizationThresholds = {{
    {0.25, 2.0 / 180.0 * std::numbers::pi},
    {0.5, 5.0 / 180.0 * std::numbers::pi},
    {5.0, 10.0 / 180.0 * std::numbers::pi},
}};

// For each threshold, the share of all `queries` whose answer is within both of its bounds. Queries without
// an answer (more queries than errors) are misses. All zero for no queries.
std::vector<double> RecallAtThresholds(std::span<const PoseError> errors, size_t queries,
                                       std::span<const PoseThreshold> thresholds = kLocalizationThresholds);

}  // namespace semmap
