#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slam/map/local_map_view.h"
#include "slam/map/map_delta.h"
#include "slam/optimize/pose_optimizer.h"
#include "slam/pipeline/frame_builder.h"
#include "slam/pipeline/keyframe_candidate.h"
#include "slam/pipeline/keyframe_id_source.h"
#include "slam/pipeline/keyframe_policy.h"
#include "slam/pipeline/local_map_matcher.h"
#include "slam/pipeline/mapping_camera.h"
#include "slam/pipeline/monocular_initializer.h"
#include "slam/pipeline/recovery.h"
#include "slam/pipeline/view_localizer.h"

namespace semmap {

// What the mapper side lets the tracker know, taken once for each frame.
struct MapperState {
  // Null before there is a map, or before the vehicle found itself in it.
  std::shared_ptr<const LocalMapView> view;
  // Others made the map, or make it as well: none is begun and none thrown away; until the first recovery
  // frames are lost.
  bool map_is_strange = false;
  bool idle = true;
  bool accepts_keyframe = true;
  // A lost frame is being looked for in the whole map; and the last one that was found.
  bool recovering = false;
  std::shared_ptr<const Recovery> recovery;
  // The frame is to be looked for in another map, too, whatever becomes of it in this one.
  bool seeks = false;
};

struct TrackOutput {
  FrameResult result;
  // Of a tracked frame.
  std::optional<FramePose> frame_pose;
  // At most one of these four.
  std::optional<KeyFrameCandidate> keyframe;
  std::optional<InitialPair> initial_pair;  // monocular: the map begins
  bool reset_map = false;                   // lost before the map was worth keeping
  std::optional<LostFrame> lost_frame;      // to be looked for in the whole map
  // The frame, if the mapper seeks.
  std::optional<LostFrame> sought;
};

// Finds the camera of each frame in the local map and decides which frames to keep. Reads the map through
// views only and waits for nothing but, for a limited time, the classes of a frame. Not thread-safe; one for
// each session.
class Tracker {
 public:
  Tracker(const SlamConfig& config, const CameraRig& rig, std::shared_ptr<SegmentationQueue> segmentation);

  absl::Status Check(const FrameInput& input) const { return builder_.Check(input); }
  // Needs a checked input.
  TrackOutput Track(const FrameInput& input, const MapperState& mapper);

  const FrameBuilder& builder() const { return builder_; }
  const MappingCamera& camera() const { return camera_; }
  // Before the first frame: where the ids of keyframes come from, when others make the same map.
  void TakeIdsFrom(std::shared_ptr<KeyFrameIdSource> ids) { ids_ = std::move(ids); }
  // Leaves its map for another one, in which it then waits to be found. New keyframes get ids from there.
  void ChangeMap(std::shared_ptr<KeyFrameIdSource> ids);
  // What the keypoints of the last tracked frame saw.
  const std::vector<MapPointId>& last_points() const { return last_points_; }

 private:
  // A point that the last frame saw: of the view, or (view_index -1) measured by depth alone.
  struct Anchor {
    int keypoint = -1;
    int32_t view_index = -1;
    Eigen::Vector3d position_in_map;
  };

  void AdoptView(std::shared_ptr<const LocalMapView> view);
  void ReportSightings(const LocalMapView& old_view);
  void RefreshLastPose();
  void AdoptRecovery(const Recovery* recovery);

  void Initialize(TrackedFrame frame, TrackOutput* output);
  void InitializeWithDepth(TrackedFrame frame, TrackOutput* output);
  void InitializeMonocular(TrackedFrame frame, TrackOutput* output);

  void TrackInMap(TrackedFrame frame, const MapperState& mapper, TrackOutput* output);
  bool Locate(TrackedFrame* frame, FrameResult* result);
  bool FollowLastFrame(TrackedFrame* frame);
  bool TrackFromLastFrame(TrackedFrame* frame);
  bool TrackFromKeyFrame(const ViewKeyFrame& keyframe, TrackedFrame* frame);
  std::optional<ViewFix> FindNearby(const TrackedFrame& frame) const;
  bool IsDoubtful(const Agreement& agreement) const;
  bool TrackLocalMap(TrackedFrame* frame, FrameResult* result);
  // Has depth, and is not of something that may move.
  bool MeasuresDepth(const Keypoint& keypoint) const {
    return keypoint.HasDepth() && !inactive_.Contains(keypoint.semantic_class);
  }
  std::vector<Anchor> LastFrameAnchors() const;
  int MatchAnchors(const std::vector<Anchor>& anchors, const SE3& predicted_camera_from_map, float radius,
                   const TrackedFrame& frame);
  // Optimizes the pose over matches_ and depth_matches_ and drops the outliers among them; returns the
  // inliers.
  int OptimizeFrame(TrackedFrame* frame, Matrix6d* covariance);
  void GatherObservations(const TrackedFrame& frame);

  void HandleLoss(const TrackedFrame& frame, const MapperState& mapper, TrackOutput* output);
  // Whether a map that was lost is not worth finding again.
  bool IsMapDisposable(const TrackedFrame& frame) const;
  void AskIfDoubtful(const TrackedFrame& frame, const MapperState& mapper, TrackOutput* output);
  void Remember(TrackedFrame frame);
  KeyFrameEvidence GatherEvidence(const TrackedFrame& frame, const MapperState& mapper, int inliers) const;
  KeyFrameCandidate MakeCandidate(const TrackedFrame& frame);
  void CountSightings();
  // Classes for each frame, or, until there is a map, for the keyframes that may follow.
  bool ClassifiesNow() const;
  ClassState SettleClasses(const FrameInput& input, bool is_classified, bool was_asked, TrackOutput* output);
  void CarryClasses(TrackedFrame* frame) const;

  SlamConfig config_;
  FrameBuilder builder_;
  MappingCamera camera_;
  MonocularInitializer monocular_initializer_;
  ProjectionSearch search_;
  // Keypoints of these classes are no reason to keep a frame and no measure of depth.
  ClassSet inactive_;

  TrackingState state_ = TrackingState::kInitializing;
  std::shared_ptr<const LocalMapView> view_;
  SightingCounters counters_;
  std::vector<PointSightings> sightings_;

  // The last tracked frame, the points its keypoints saw, and its pose relative to keyframes, by which it
  // moves along when the mapper adjusts the map: first choice its own keyframe, if it became one.
  std::optional<TrackedFrame> last_;
  std::vector<MapPointId> last_points_;
  KeyFrameId last_reference_;
  SE3 last_camera_from_reference_;
  KeyFrameId last_keyframe_;
  std::optional<SE3> velocity_;  // camera_from_last_camera of the last two frames
  TimestampNs last_keyframe_time_ = 0;
  std::shared_ptr<KeyFrameIdSource> ids_ = std::make_shared<KeyFrameIdSource>();
  // Of the current frame: whether it was found without the last one, and how much of the map agrees.
  bool relocalized_ = false;
  Agreement agreement_;
  int frames_since_asked_ = 0;
  // Frame of the last recovery that was taken up.
  uint64_t recovered_sequence_ = 0;

  // Matches of the current frame: points of the view, and anchors without one.
  ViewMatches matches_;
  std::vector<std::optional<Eigen::Vector3d>> depth_matches_;
  std::vector<PoseObservation> observations_;
  std::vector<int> observed_keypoints_;
  std::vector<char> outliers_;
  StageTimes times_;
};

}  // namespace semmap
