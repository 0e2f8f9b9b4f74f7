#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "slam/common/ids.h"
#include "slam/common/time.h"
#include "slam/features/frame_features.h"
#include "slam/geometry/se3.h"
#include "slam/semantics/class_votes.h"

namespace semmap {

// The records in which a map leaves the algorithm: what the store keeps and viewers watch. All are plain
// values.

struct KeyFrameRecord {
  KeyFrameId id;
  // Which vehicle frame it was.
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  SE3 map_from_camera;
  // Tree over the map's keyframes; none for the first.
  KeyFrameId parent;
  // Immutable after creation and therefore shared instead of copied. Never null.
  std::shared_ptr<const FrameFeatures> features;
};

struct KeyFramePose {
  KeyFrameId id;
  SE3 map_from_camera;
  KeyFrameId parent;
  // Translations relative to this keyframe (of the frames that hang on it so far) grow by this factor:
  // monocular loop closing changes the scale of what was seen from it. Applied before the frames of the same
  // delta, which have the new scale already.
  double rescale = 1.0;
};

// Which map point each keypoint of a keyframe sees; none where it sees none. As long as features->keypoints.
struct KeyFrameObservations {
  KeyFrameId id;
  std::vector<MapPointId> point_of_keypoint;
  // The keypoints that are meant, for a store that did not keep all of them; null where they are not at hand.
  std::shared_ptr<const FrameFeatures> features = nullptr;
};

struct MapPointRecord {
  MapPointId id;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  // Mean viewing direction, from cameras to the point, unit length.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  // Distances from which the point's corner can be found on the pyramid, metres.
  float min_distance = 0;
  float max_distance = 0;
  Descriptor descriptor;
  KeyFrameId reference_keyframe;
  // How many keyframes see it.
  uint32_t observation_count = 0;
  // Time of the newest observation and of the oldest, by keyframe.
  TimestampNs first_seen = 0;
  TimestampNs last_seen = 0;
  uint8_t semantic_class = kUnknownClass;  // by the map's PointClassPolicy: the most frequent vote
  float class_confidence = 0;              // its share of the votes
  // In the order in which the classes were seen first.
  std::vector<ClassVote> votes;
};

// Pose of one vehicle frame, relative to a keyframe so that later corrections of the keyframe move it along:
// map_from_camera = keyframe.map_from_camera * keyframe_from_camera.
struct FramePose {
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  KeyFrameId reference_keyframe;
  SE3 keyframe_from_camera;
};

// A culled keyframe leaves its frames to another one:
// frames of `removed` become relative to `heir` by heir_from_camera = heir_from_removed *
// removed_from_camera.
struct RemovedKeyFrame {
  KeyFrameId removed;
  KeyFrameId heir;
  SE3 heir_from_removed;
};

// Poses reported for the frames from_sequence to through_sequence have moved for more than the usual
// refinement (a loop was closed): corrected = corrected_from_reported * reported, the rotation without the
// scale.
struct PoseCorrection {
  uint64_t from_sequence = 0;
  uint64_t through_sequence = 0;
  Sim3 corrected_from_reported;
};

// Everything that one step of the mapper changed; applied as one transaction, in the order of the members
// below. Applying deltas in order from an empty map reproduces the map.
struct MapDelta {
  // Forget everything first: the map started over (monocular tracking lost right after its start).
  bool reset = false;
  // Grows by one with each delta of a session.
  uint64_t version = 0;
  std::vector<KeyFrameRecord> added_keyframes;
  std::vector<KeyFramePose> moved_keyframes;
  std::vector<MapPointRecord> upserted_points;
  std::vector<KeyFrameObservations> observations;
  std::vector<RemovedKeyFrame> removed_keyframes;
  std::vector<MapPointId> removed_points;
  std::vector<FramePose> frames;
  // Frames from this one on may wait for the piece that the vehicle mapped on its own to be joined, and are not
  // durable; 0: none wait.
  uint64_t waiting_from = 0;
  // For the vehicle, not for the store, which has the new poses: with a loop and the adjustment that follows
  // it, the whole of the session, otherwise nothing; and the first FrameResult::map_version that has them.
  std::vector<PoseCorrection> corrections;
  uint64_t corrected_map_version = 0;

  bool empty() const {
    return !reset && added_keyframes.empty() && moved_keyframes.empty() && upserted_points.empty() &&
           observations.empty() && removed_keyframes.empty() && removed_points.empty() && frames.empty();
  }
};

// Receives the deltas of one session, in order, from one thread at a time. Must not block for long: it holds
// up the mapper (never the tracker).
class MapDeltaSink {
 public:
  virtual ~MapDeltaSink() = default;
  virtual void OnDelta(MapDelta delta) = 0;
};

}  // namespace semmap
