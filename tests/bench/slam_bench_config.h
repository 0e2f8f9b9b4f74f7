#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/pipeline/slam_config.h"

namespace semmap::bench {

// The `slam` section of a file (empty path: the defaults) with single settings changed, each as
// "slam.semantics.penalty=0" with a value in YAML. INVALID_ARGUMENT for what the file's reader would refuse,
// too.
absl::StatusOr<SlamConfig> ReadSlamConfig(const std::string& path, const std::vector<std::string>& settings);

}  // namespace semmap::bench
