#pragma once

#include <deque>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "slam/common/ids.h"
#include "slam/features/frame_features.h"
#include "slam/map/keyframe.h"
#include "slam/map/map_delta.h"
#include "slam/map/map_point.h"

namespace semmap {

using KeyFrameIdMap = std::unordered_map<KeyFrameId, KeyFrameId, IdHash>;

struct CovisibleKeyFrame {
  KeyFrameId id;
  int shared_points = 0;
};

// Keyframes, points and what sees what. Every change goes through a method, which keeps both directions of an
// observation and the covisibility counts consistent and notes what a delta must carry. Not thread-safe: it
// belongs to the mapper; others see it through LocalMapView and MapDelta. Iteration order depends
// on the history only, so results are reproducible. References stay valid until the thing itself is removed.
class Map {
 public:
  explicit Map(ScalePyramidInfo scale_info, PointClassPolicy classes = {})
      : scale_info_(std::move(scale_info)), classes_(classes) {}

  // --- reading
  const KeyFrame* FindKeyFrame(KeyFrameId id) const;
  const MapPoint* FindPoint(MapPointId id) const;
  const std::unordered_map<KeyFrameId, KeyFrame, IdHash>& keyframes() const { return keyframes_; }
  const std::unordered_map<MapPointId, MapPoint, IdHash>& points() const { return points_; }
  // nullptr also when the point is inactive.
  const MapPoint* FindActivePoint(MapPointId id) const;
  const ScalePyramidInfo& scale_info() const { return scale_info_; }
  KeyFrameId newest_keyframe() const { return newest_keyframe_; }
  // Neighbours by falling number of shared points (ties: newer first), at least `min_shared`, at most
  // `limit`.
  std::vector<CovisibleKeyFrame> BestCovisible(KeyFrameId id, size_t limit, int min_shared = 1) const;
  // Active points of the keyframe that at least `min_observations` keyframes see.
  int CountPoints(KeyFrameId id, int min_observations) const;

  // --- changing
  // keyframe.points must be as long as its features and empty of observations.
  void AddKeyFrame(KeyFrame keyframe);
  MapPointId AddPoint(const Eigen::Vector3d& position_in_map, KeyFrameId reference);
  // The keypoint's class is a vote on the point's, which may activate or deactivate it.
  // False (and nothing changes) when either is gone, the keypoint sees another point, or the keyframe sees it
  // already.
  bool AddObservation(MapPointId point, KeyFrameId keyframe, uint32_t keypoint);
  // For an observation that was wrong: its vote is taken back. Removes the point as well when fewer than two
  // observations remain.
  void RemoveObservation(MapPointId point, KeyFrameId keyframe);
  void RemovePoint(MapPointId point);
  // `dropped`'s votes and observations become `kept`'s where that keyframe has none yet; dropped is removed.
  void MergePoints(MapPointId kept, MapPointId dropped);
  // The parent of the keyframe inherits its frames and children. The first keyframe cannot be removed.
  void RemoveKeyFrame(KeyFrameId id);
  void SetPose(KeyFrameId id, const SE3& camera_from_map);
  // The keyframe's surroundings were found to be `factor` times as large as they were taken to be: what hangs
  // on it by a relative pose must grow with it. Noted for the delta only; poses and points are set by their
  // own methods.
  void NoteRescaled(KeyFrameId id, double factor);
  void SetPosition(MapPointId id, const Eigen::Vector3d& position_in_map);
  // Says that two keyframes show one place, for later pose graphs. Forgotten when either is removed.
  void AddLoop(KeyFrameId first, KeyFrameId second);
  void AddSightings(MapPointId id, uint32_t visible, uint32_t found);
  // Chooses the parent of a keyframe: the older neighbour that shares most points.
  void ChooseParent(KeyFrameId id);
  // Joins two trees: `parent`, of another one, becomes the parent of `id`, and its ancestors its descendants.
  void GraftTree(KeyFrameId id, KeyFrameId parent);
  // Representative descriptor (smallest median distance to the others), mean viewing direction and distance
  // bounds.
  void UpdateAppearance(MapPointId id);
  // The last two only: enough after the point or its observers moved.
  void UpdateViewing(MapPointId id);
  void Clear();
  // Lays `piece`, in its own frame, beside what is there: with ids that are greater than all here, for each
  // keyframe of the piece one, and new ones for its points. Without the heirs of what it removed.
  void Append(const Map& piece, const KeyFrameIdMap& new_ids);
  // Takes away keyframes that Append brought, and their points, while nothing else sees these.
  void Drop(const std::vector<KeyFrameId>& ids);

  // What changed since the last call, ready for the sink; `frames` and `version` are the caller's to fill.
  MapDelta TakeDelta();
  // Where the frames of a removed keyframe went; nullopt when `id` was never removed, or so long ago that no
  // frame in flight can refer to it.
  std::optional<RemovedKeyFrame> FindHeir(KeyFrameId id) const;
  // Hangs the frame on a keyframe that is still there; false when none is known that inherited it.
  bool Resolve(FramePose* frame) const;
  // What NoteRescaled made of a keyframe since the last delta. A delta tells it of those only that the sink
  // knows already.
  double RescaledBy(KeyFrameId id) const;

 private:
  friend class MapRestorer;  // fills it from records

  KeyFrame& keyframe(KeyFrameId id) { return keyframes_.at(id); }
  // What both have in common: the part of AddObservation that is no vote, and of RemoveObservation.
  bool Attach(MapPoint* point, KeyFrame* observer, uint32_t keypoint);
  void Detach(MapPointId point, KeyFrameId keyframe, bool take_vote_back);
  // After the votes have changed.
  void Reclassify(MapPoint* point);
  void SetActive(MapPoint* point, bool active);
  void ChangeShared(KeyFrame* own, KeyFrame* other, int change);
  void CountShared(const MapPoint& point, KeyFrameId observer, int change);
  void DetachFromTree(const KeyFrame& removed);
  MapPointRecord ToRecord(const MapPoint& point) const;
  void UpdateGeometry(MapPoint& point) const;
  void UpdateDescriptor(MapPoint& point) const;

  template <typename Id>
  using IdSet = std::unordered_set<Id, IdHash>;

  ScalePyramidInfo scale_info_;
  PointClassPolicy classes_;
  std::unordered_map<KeyFrameId, KeyFrame, IdHash> keyframes_;
  std::unordered_map<MapPointId, MapPoint, IdHash> points_;
  uint64_t next_point_id_ = 1;
  KeyFrameId newest_keyframe_;
  KeyFrameId first_keyframe_;
  // Heirs of the keyframes removed last, and in which order they went.
  std::unordered_map<KeyFrameId, RemovedKeyFrame, IdHash> heirs_;
  std::deque<KeyFrameId> removal_order_;

  bool was_reset_ = false;
  IdSet<KeyFrameId> added_keyframes_;
  IdSet<KeyFrameId> moved_keyframes_;
  std::unordered_map<KeyFrameId, double, IdHash> rescaled_keyframes_;
  IdSet<KeyFrameId> reobserved_keyframes_;
  IdSet<MapPointId> changed_points_;
  // Points the sink has heard of, among those removed since.
  std::vector<MapPointId> removed_points_;
  std::vector<RemovedKeyFrame> removed_keyframes_;
  IdSet<MapPointId> new_points_;
};

}  // namespace semmap
