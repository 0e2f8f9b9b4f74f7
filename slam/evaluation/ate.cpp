#include "slam/evaluation/ate.h"

#include "slam/common/status_macros.h"
#include "slam/geometry/alignment.h"

namespace semmap {

std::optional<Alignment> ParseAlignment(std::string_view name) {
  if (name == "none") return Alignment::kNone;
  if (name == "se3") return Alignment::kSe3;
  if (name == "sim3") return Alignment::kSim3;
  return std::nullopt;
}

absl::StatusOr<Sim3> AlignTrajectory(const std::vector<PosePair>& pairs, Alignment alignment) {
  if (pairs.empty()) return absl::InvalidArgumentError("there are no pairs of poses to compare");
  if (alignment == Alignment::kNone) return Sim3{};
  std::vector<Eigen::Vector3d> reference;
  std::vector<Eigen::Vector3d> estimate;
  for (const PosePair& pair : pairs) {
    reference.push_back(pair.reference.translation());
    estimate.push_back(pair.estimate.translation());
  }
  return AlignPoints(estimate, reference, alignment == Alignment::kSim3);
}

absl::StatusOr<AteResult> ComputeAte(const std::vector<PosePair>& pairs, Alignment alignment) {
  AteResult result;
  SEMMAP_ASSIGN_OR_RETURN(result.reference_from_estimate, AlignTrajectory(pairs, alignment));
  result.errors_m.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d aligned = result.reference_from_estimate * pair.estimate.translation();
    result.errors_m.push_back((pair.reference.translation() - aligned).norm());
  }
  result.translation_m = Summarize(result.errors_m);
  return result;
}

}  // namespace semmap
