#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/client.h"
#include "semmap/v1/localization_service.pb.h"
#include "slam/evaluation/recall.h"
#include "slam/geometry/camera.h"
#include "tests/bench/map_truth.h"

namespace semmap::bench {

struct QueryOptions {
  std::string map;
  std::string source;  // of the pictures
  std::string truth;   // their poses in the frame of the map's truth, KITTI's format, one line for each
  SensorType sensor = SensorType::kMono;
  // Which pictures to ask about.
  int every = 1;
  int skip = 0;
  // A vehicle drives all of them through a LOCALIZE session instead; `every` and `skip` do not hold.
  bool drive = false;
  // Places that the map saw from the other direction are in it, too.
  bool any_heading = false;
};

// One picture and what became of it.
struct Answer {
  size_t frame = 0;
  // Of a drive's estimate as far as it has such fields.
  v1::RelocalizeResponse response;
  PoseError error;        // FOUND only
  PoseError local_error;  // the same, the map aligned to the truth around the picture
  double distance_m = 0;  // from the nearest keyframe
  bool in_map = false;

  bool found() const { return response.result() == v1::RELOCALIZE_RESULT_FOUND; }
};

absl::StatusOr<std::vector<Answer>> AskAll(client::Client& client,
                                           const std::shared_ptr<client::Connection>& connection,
                                           const QueryOptions& options, const MapTruth& map);

}  // namespace semmap::bench
