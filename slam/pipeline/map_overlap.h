#pragma once

#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/map/map.h"
#include "slam/pipeline/loop_verifier.h"
#include "slam/pipeline/mapping_camera.h"
#include "slam/pipeline/place_memory.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// What two maps show in common, as found by FindOverlap.
struct MapOverlap {
  // Its scale is how many units of the target one unit of the source is.
  Sim3 target_from_source;
  // Keyframes of the source (`current`) found near keyframes of the target (`old`), each once, ascending; all
  // agree with target_from_source.
  std::vector<Loop> links;
  int keyframes = 0;  // of the source, looked for
  int found = 0;      // in the target, wherever
  int rivals = 0;     // found, and of one mind about another similarity
  double depth = 0;   // median of what keyframes see where they were found, in units of the target

  // Whether it is safe to join the maps by it.
  bool IsSound(const MergeConfig& config) const;
  // Whether a frame of the source that was found in the target by other means was found where the overlap
  // puts it, and that leaves no doubt.
  bool IsConfirmedBy(const SE3& source_from_camera, const SE3& target_from_camera) const;
};

// Called with the share of the work that is done, [0, 1]; false ends the work with CANCELLED.
using StepVisitor = std::function<bool(double)>;

// Looks for places of one map, the source, in another one. `map` holds both side by side, each in a frame
// (and a unit, without depth) of its own and without ties between them: the source's are the keyframes with
// greater ids than `last_of_target`. `places` knows all of them. Each keyframe of the source is looked for by
// appearance and verified as a loop is (VerifyLoop); what it then tells of the two frames must be told by
// others as well, since one wrong place looks as good as a right one, but several seldom agree.
// Deterministic.
absl::StatusOr<MapOverlap> FindOverlap(const SlamConfig& config, const MappingCamera& camera,
                                       const PlaceMemory& places, const Map& map, KeyFrameId last_of_target,
                                       const StepVisitor& visit);

}  // namespace semmap
