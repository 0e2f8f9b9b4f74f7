#include "slam/pipeline/loop_corrector.h"

#include <vector>

#include "slam/pipeline/essential_graph.h"
#include "slam/pipeline/point_fusion.h"

namespace semmap {
namespace {

// A loop, measured once but free of drift, must not give way to the many measurements between.
constexpr double kLoopPrecision = 0.03;
// Keyframes around either end whose points are joined.
constexpr size_t kFusedNeighbours = 20;
// Before the bundle adjustment the two sides agree to some pixels only.
constexpr FusionTolerance kRoughFusion{8.0F, 5.0F};

std::vector<KeyFrameId> GroupOf(const Map& map, KeyFrameId id) {
  std::vector<KeyFrameId> group = {id};
  for (const CovisibleKeyFrame& neighbour : map.BestCovisible(id, kFusedNeighbours))
    group.push_back(neighbour.id);
  return group;
}

}  // namespace

int FuseLoopEnds(const MappingCamera& camera, const Loop& loop, Map* map) {
  const std::vector<KeyFrameId> old_group = GroupOf(*map, loop.old);
  const std::vector<KeyFrameId> current_group = GroupOf(*map, loop.current);
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

LoopCorrection CloseLoop(const LoopConfig& config, const MappingCamera& camera, const Loop& loop, Map* map) {
  LoopCorrection correction;
  EssentialGraph graph(config.pose_graph_min_shared, !camera.HasDepth(), *map);
  graph.AddLoop(loop, kLoopPrecision);
  PoseGraphOptions options;
  options.max_iterations = config.pose_graph_iterations;
  correction.pose_graph = graph.Optimize(options);
  const Sim3& corrected = graph.MapFromKeyFrame(loop.current);
  correction.shift = (corrected.rigid.translation() - map->FindKeyFrame(loop.current)->Center()).norm();
  correction.scale = corrected.scale;
  graph.WriteBack(map);
  map->AddLoop(loop.old, loop.current);
  correction.fused_points = FuseLoopEnds(camera, loop, map);
  for (const auto& [id, point] : map->points()) map->UpdateViewing(id);
  return correction;
}

}  // namespace semmap
