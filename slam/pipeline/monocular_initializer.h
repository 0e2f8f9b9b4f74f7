#pragma once

#include <optional>
#include <vector>

#include "slam/geometry/two_view.h"
#include "slam/pipeline/association.h"
#include "slam/pipeline/frame_builder.h"

namespace semmap {

// Two frames with enough parallax, their relative pose and what both see. The first camera is the map's
// origin and the median depth of the points in it is one: a single moving camera cannot know its scale.
struct InitialReconstruction {
  TrackedFrame first;
  SE3 second_from_first;
  struct Point {
    Eigen::Vector3d position_in_first;
    int keypoint_in_first;
    int keypoint_in_second;
  };
  std::vector<Point> points;
};

// Waits for a frame that, together with an earlier one, tells motion and structure. Not thread-safe.
class MonocularInitializer {
 public:
  // Keypoints of inactive classes take no part: what moves would tell its own motion.
  MonocularInitializer(const CameraIntrinsics& camera, uint32_t seed, const SemanticsConfig& semantics)
      : camera_(camera), seed_(seed), rule_(semantics), inactive_(semantics.InactiveClasses()) {}

  std::optional<InitialReconstruction> Add(const TrackedFrame& frame);
  void Reset() { reference_.reset(); }

 private:
  void StartOver(const TrackedFrame& frame);
  std::vector<KeypointPair> Match(const TrackedFrame& frame);
  std::optional<InitialReconstruction> Reconstruct(const TrackedFrame& frame,
                                                   const std::vector<KeypointPair>& pairs);

  CameraIntrinsics camera_;
  uint32_t seed_;
  AssociationRule rule_;
  ClassSet inactive_;
  std::optional<TrackedFrame> reference_;
  // Where each keypoint of the reference was seen last: the search follows it from frame to frame.
  std::vector<Eigen::Vector2f> last_seen_;
};

}  // namespace semmap
