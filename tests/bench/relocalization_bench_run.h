#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/bench/slam_bench_options.h"

namespace semmap::bench {

// What happens to the vehicle of a trial.
enum class Ordeal {
  kBlindfold,  // sees nothing for a while, then drives on where it was
  kBack,       // sees nothing for a while, then drives the last stretch of the street again
  kKidnap,     // finds itself some way back on the street, and a little later further along it
};

const char* NameOf(Ordeal ordeal);

struct RelocalizationOptions {
  BenchOptions bench;
  int trials = 20;  // of each kind, spread evenly over the recording
  int black_frames = 30;
  double distance_m =
      10;             // how far a kidnapped vehicle is carried, and how far back a blindfolded one begins
  int patience = 30;  // frames after which a trial counts as failed
};

struct TrialResult {
  Ordeal ordeal = Ordeal::kBlindfold;
  size_t frame = 0;       // of the recording, at which the vehicle saw again
  bool was_lost = false;  // for at least one frame
  // The frame, counted from 1, that was tracked again; nothing when patience ended.
  std::optional<int> found_after;
  // Motion since the last frame before, against the truth.
  double error_m = 0;
};

// Drives through the recording and puts the vehicle to trial on the way. FAILED_PRECONDITION without ground
// truth, or when the vehicle is lost where it should not be.
absl::StatusOr<std::vector<TrialResult>> RunTrials(const RelocalizationOptions& options);

}  // namespace semmap::bench
