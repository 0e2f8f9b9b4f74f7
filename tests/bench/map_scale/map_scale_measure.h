#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/bench/map_scale/map_scale_options.h"

namespace semmap::bench {

// Milliseconds of wall time unless they say otherwise.
struct MapScaleResult {
  uint64_t keyframes = 0;
  uint64_t points = 0;
  double kilometres = 0;
  uint64_t file_bytes = 0;

  // From opening the map to the first answer; of that, opening.
  struct Opening {
    double open_ms = 0;
    double first_answer_ms = 0;
  };
  Opening from_disk;        // of a file that is in no cache of the system
  Opening from_page_cache;  // right after that, by a process that has forgotten the map
  // Each query, the extraction of features left out; that by itself.
  std::vector<double> relocalize_ms;
  std::vector<double> extract_ms;
  uint64_t found = 0;
  uint64_t right = 0;  // within 0.5 m and 5 degrees of where the drive was
  // A vehicle that drives in the map, each frame, everything included.
  std::vector<double> localize_ms;
  uint64_t localized = 0;
  // Of the process after that: all of it, the most it ever was, what it was before the map was opened; and
  // what the map is accounted.
  double resident_mb = 0;
  double peak_mb = 0;
  double before_mb = 0;
  double map_mb = 0;
  double core_mb = 0;

  std::vector<double> box_ms;
  std::vector<double> box_points;
};

// Needs a process that has not made the map itself: memory is that of the process.
absl::StatusOr<MapScaleResult> Measure(const MapScaleOptions& options);

}  // namespace semmap::bench
