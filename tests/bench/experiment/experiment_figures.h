#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "slam/evaluation/trajectory.h"
#include "tests/bench/experiment/variant_result.h"

namespace semmap::bench {

// The paper's Fig. 5 above and Fig. 4 below, of one drive: the true trajectory (blue) and those of the
// variants, and the distance from the truth for each frame, as a PNG. The base algorithm is orange, the first
// other one green.
absl::Status WriteFigures(const std::string& path, const std::string& title, const Trajectory& truth,
                          const std::vector<const VariantResult*>& results);

}  // namespace semmap::bench
