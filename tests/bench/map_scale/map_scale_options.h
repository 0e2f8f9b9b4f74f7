#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "slam/geometry/camera.h"
#include "slam/pipeline/slam_config.h"
#include "storage/storage_config.h"

namespace semmap::bench {

// What the benchmark of large maps does.
struct MapScaleOptions {
  // Where the maps are made, and found again by the next run.
  std::string work;
  // The drive that is laid side by side: KIND:PATH of a recording, or a route of the town.
  std::string source = "town:2";
  SensorType sensor = SensorType::kStereo;
  int frames = 700;
  // The map has at least so many of both.
  uint64_t keyframes = 10'000;
  uint64_t points = 1'000'000;
  size_t memory_mb = 512;
  int queries = 300;
  // Instead of parts as they are needed, the whole map is loaded, as much memory as it takes.
  bool whole = false;
  SlamConfig slam;

  std::string DrivePath() const { return work + "/drive.db"; }
  std::string QueryFolder() const { return work + "/queries"; }
  std::string MapPath() const { return work + "/map.db"; }
};

inline storage::StorageConfig StoreAt(const std::string& path) {
  storage::StorageConfig config;
  config.uri = "sqlite://" + path;
  return config;
}

}  // namespace semmap::bench
