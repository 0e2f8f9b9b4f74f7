#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/bench/experiment/recorded_drive.h"
#include "tests/bench/experiment/variant.h"
#include "tests/bench/experiment/variant_result.h"

namespace semmap::bench {

struct RunOptions {
  SlamConfig config;
  std::string model;  // name of the recorded masks that variants with a model use
  // Runs over one drive begin at different frames, the first at frame 0. Monocular SLAM is chaotic: another
  // start gives another drift, and one run alone says little.
  int run = 1;
  int frame_step = 1;  // every frame, every second one...
};

// Plays the drive once, frame by frame, through one session for each variant: all get the same frames.
absl::StatusOr<std::vector<VariantResult>> RunVariants(const RecordedDrive& drive,
                                                       const std::vector<Variant>& variants,
                                                       const RunOptions& options,
                                                       const std::function<void(int)>& progress);

}  // namespace semmap::bench
