#include "slam/pipeline/loop_corrector.h"

#include <algorithm>
#include <set>
#include <unordered_map>

#include "slam/pipeline/point_fusion.h"

namespace semmap {
namespace {

// Relative poses along the drive are good to these shares of the distance, radians and shares of the scale; a
// loop, measured once but free of drift, must not give way to the many measurements between.
constexpr double kDriveTranslation = 0.01;
constexpr double kDriveRotation = 0.001;
constexpr double kDriveScale = 0.01;
constexpr double kLoopPrecision = 0.03;
// Keyframes around either end whose points are joined.
constexpr size_t kFusedNeighbours = 20;
// Before the bundle adjustment the two sides agree to some pixels only.
constexpr FusionTolerance kRoughFusion{8.0F, 5.0F};

// The pose graph of a map, with the keyframes that its nodes are.
class EssentialGraph {
 public:
  EssentialGraph(const LoopConfig& config, bool with_scale, const Map& map) {
    graph_.with_scale = with_scale;
    for (const auto& [id, keyframe] : map.keyframes()) ids_.push_back(id);
    std::sort(ids_.begin(), ids_.end());
    for (const KeyFrameId id : ids_) {
      const KeyFrame& keyframe = *map.FindKeyFrame(id);
      index_.emplace(id, static_cast<int>(graph_.nodes.size()));
      graph_.nodes.push_back({{1.0, keyframe.camera_from_map.Inverse()}, !keyframe.parent.IsValid()});
    }
    for (const KeyFrameId id : ids_) AddEdgesOf(*map.FindKeyFrame(id), config.pose_graph_min_shared);
    typical_distance_ = TypicalDistance();
    for (PoseGraphEdge& edge : graph_.edges) Weigh(1.0, &edge);
  }

  void AddLoop(const Loop& loop) {
    PoseGraphEdge edge{index_.at(loop.old), index_.at(loop.current), loop.old_from_current};
    Weigh(kLoopPrecision, &edge);
    graph_.edges.push_back(edge);
  }

  PoseGraphSummary Optimize(int iterations) {
    PoseGraphOptions options;
    options.max_iterations = iterations;
    return OptimizePoseGraph(options, &graph_);
  }

  const Sim3& MapFromKeyFrame(KeyFrameId id) const { return graph_.nodes[index_.at(id)].map_from_keyframe; }
  const std::vector<KeyFrameId>& ids() const { return ids_; }

 private:
  void AddEdgesOf(const KeyFrame& keyframe, int min_shared) {
    std::set<KeyFrameId> tied(keyframe.loops.begin(), keyframe.loops.end());
    for (const auto& [other, shared] : keyframe.covisible) {
      if (shared >= min_shared) tied.insert(other);
    }
    std::erase_if(tied, [&](KeyFrameId other) { return other > keyframe.id; });  // each pair once
    if (keyframe.parent.IsValid()) tied.insert(keyframe.parent);
    for (const KeyFrameId other : tied) AddEdge(other, keyframe.id);
  }

  // As the poses are now.
  void AddEdge(KeyFrameId from, KeyFrameId to) {
    const Sim3 from_from_to = MapFromKeyFrame(from).Inverse() * MapFromKeyFrame(to);
    graph_.edges.push_back({index_.at(from), index_.at(to), from_from_to});
  }

  double TypicalDistance() const {
    std::vector<double> distances;
    for (const PoseGraphEdge& edge : graph_.edges)
      distances.push_back(edge.from_from_to.rigid.translation().norm());
    if (distances.empty()) return 1;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return std::max(*middle, 1e-9);
  }

  void Weigh(double precision, PoseGraphEdge* edge) const {
    const double distance = std::max(edge->from_from_to.rigid.translation().norm(), typical_distance_);
    edge->translation_sigma = precision * kDriveTranslation * distance;
    edge->rotation_sigma = precision * kDriveRotation;
    edge->scale_sigma = precision * kDriveScale;
  }

  PoseGraph graph_;
  std::vector<KeyFrameId> ids_;
  std::unordered_map<KeyFrameId, int, IdHash> index_;
  double typical_distance_ = 1;
};

// Points keep their place in the frame of their reference keyframe, whose unit may have changed.
void MovePoints(const EssentialGraph& graph, Map* map) {
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> moved;
  for (const auto& [id, point] : map->points()) {
    const KeyFrame& reference = *map->FindKeyFrame(point.reference_keyframe);
    const Eigen::Vector3d in_reference = reference.camera_from_map * point.position_in_map;
    moved.emplace_back(id, graph.MapFromKeyFrame(reference.id) * in_reference);
  }
  for (const auto& [id, position] : moved) map->SetPosition(id, position);
}

void MoveKeyFrames(const EssentialGraph& graph, Map* map) {
  for (const KeyFrameId id : graph.ids()) {
    const Sim3& map_from_keyframe = graph.MapFromKeyFrame(id);
    map->SetPose(id, map_from_keyframe.rigid.Inverse());
    if (map_from_keyframe.scale != 1) map->NoteRescaled(id, map_from_keyframe.scale);
  }
}

std::vector<KeyFrameId> GroupOf(const Map& map, KeyFrameId id) {
  std::vector<KeyFrameId> group = {id};
  for (const CovisibleKeyFrame& neighbour : map.BestCovisible(id, kFusedNeighbours))
    group.push_back(neighbour.id);
  return group;
}

// What both images were seen to show is one; then what both groups show.
int FuseEnds(const MappingCamera& camera, const Loop& loop, const std::vector<KeyFrameId>& old_group,
             const std::vector<KeyFrameId>& current_group, Map* map) {
  int fused = 0;
  for (const auto& [point, keypoint] : loop.seen) {
    if (map->FindPoint(point) != nullptr && JoinPoint(point, loop.current, static_cast<int>(keypoint), map))
      ++fused;
  }
  const std::vector<MapPointId> old_points = PointsSeenBy(*map, old_group);
  for (const KeyFrameId keyframe : current_group)
    fused += FusePoints(camera, old_points, keyframe, kRoughFusion, map);
  return fused;
}

}  // namespace

LoopCorrection CloseLoop(const LoopConfig& config, const MappingCamera& camera, const Loop& loop, Map* map) {
  const std::vector<KeyFrameId> old_group = GroupOf(*map, loop.old);
  const std::vector<KeyFrameId> current_group = GroupOf(*map, loop.current);
  LoopCorrection correction;
  EssentialGraph graph(config, !camera.HasDepth(), *map);
  graph.AddLoop(loop);
  correction.pose_graph = graph.Optimize(config.pose_graph_iterations);
  const Sim3& corrected = graph.MapFromKeyFrame(loop.current);
  correction.shift = (corrected.rigid.translation() - map->FindKeyFrame(loop.current)->Center()).norm();
  correction.scale = corrected.scale;
  MovePoints(graph, map);
  MoveKeyFrames(graph, map);
  map->AddLoop(loop.old, loop.current);
  correction.fused_points = FuseEnds(camera, loop, old_group, current_group, map);
  for (const auto& [id, point] : map->points()) map->UpdateViewing(id);
  return correction;
}

}  // namespace semmap
