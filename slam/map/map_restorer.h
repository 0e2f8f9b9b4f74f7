#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/geometry/camera.h"
#include "slam/map/map.h"
#include "slam/map/map_delta.h"

namespace semmap {

// Rebuilds a Map from the records in which it left: what reads of it (poses, features, observations in both
// directions, covisibility, spanning tree, appearance of points) is as it was. Not kept by records and
// therefore lost: loops, counts of sightings (points are no longer on probation) and the order in which a
// point was observed, which becomes that of the keyframes' ids. Points are added before the keyframes that
// see them.
//
// Every method answers DATA_LOSS for records that contradict each other; the restorer is then of no more use.
class MapRestorer {
 public:
  // Ids of new points will be greater than `last_point`. Votes are those of the records; class and activity
  // follow from them anew, by `classes`.
  MapRestorer(const ScalePyramidInfo& scale_info, MapPointId last_point, PointClassPolicy classes = {});

  absl::Status AddPoint(const MapPointRecord& record);
  // `bounds` are those of the undistorted image. `observations` is as long as record.features.
  absl::Status AddKeyFrame(const KeyFrameRecord& record, const ImageBounds& bounds,
                           std::vector<MapPointId> observations);

  // Bytes that the map takes by now, give or take a tenth.
  size_t memory_bytes() const { return memory_bytes_; }
  // The map, of which nothing counts as changed.
  absl::StatusOr<Map> Finish() &&;

 private:
  absl::Status Observe(MapPointId point, KeyFrameId keyframe, uint32_t keypoint);

  Map map_;
  size_t memory_bytes_ = 0;
};

}  // namespace semmap
