#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/common/ids.h"
#include "slam/geometry/camera.h"
#include "slam/map/map_delta.h"

namespace semmap {

// A keyframe as it is stored.
struct StoredKeyFrame {
  KeyFrameRecord record;
  ImageBounds bounds;  // of the undistorted image
  // As long as record.features.
  std::vector<MapPointId> observations;
};

// Reads parts of a map that lies elsewhere, all as they were at one instant. For one thread.
class MapPartReader {
 public:
  virtual ~MapPartReader() = default;
  // Of the map at that instant. What belongs to different versions may contradict itself.
  virtual uint64_t version() const = 0;
  // nullopt when the map has no such keyframe.
  virtual absl::StatusOr<std::optional<StoredKeyFrame>> ReadKeyFrame(KeyFrameId id) = 0;
  // The map's points with ids in [first, last], ascending.
  virtual absl::Status ReadPoints(MapPointId first, MapPointId last,
                                  absl::FunctionRef<void(const MapPointRecord&)> visit) = 0;
};

// Where the parts of one map are read from. Thread-safe.
class MapPartSource {
 public:
  virtual ~MapPartSource() = default;
  // Calls `read` at most once; its failure, or that of getting at the map, is the answer.
  virtual absl::Status Read(absl::FunctionRef<absl::Status(MapPartReader&)> read) = 0;
};

}  // namespace semmap
