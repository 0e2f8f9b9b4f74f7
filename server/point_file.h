#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "semmap/v1/map_service.pb.h"
#include "server/output_file.h"
#include "slam/map/map_delta.h"

namespace semmap::server {

// Writes points to a file that other programs read, with the colours of their classes; holds one point at a
// time. Not thread-safe.
class PointFile {
 public:
  virtual ~PointFile() = default;
  virtual absl::Status Add(const MapPointRecord& point) = 0;
  // What belongs behind the last point. Last call.
  virtual absl::Status Finish() = 0;
};

// PLY, binary, little endian: x y z (float), red green blue class (uchar), confidence (float), observations
// (uint). PCD 0.7, binary: x y z rgb (as float, the Point Cloud Library's packing), label (uint), confidence
// (float), observations (uint). CSV: a heading, then one line for each point. Null for other formats.
std::unique_ptr<PointFile> MakePointFile(v1::MapFileFormat format, OutputFile* output);

// Red, green and blue of a class; white, which no class has, for points of none.
std::array<uint8_t, 3> ColourOf(uint8_t semantic_class);

}  // namespace semmap::server
