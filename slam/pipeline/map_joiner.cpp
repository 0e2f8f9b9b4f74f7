#include "slam/pipeline/map_joiner.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "slam/pipeline/essential_graph.h"
#include "slam/pipeline/full_bundle.h"
#include "slam/pipeline/loop_corrector.h"

namespace semmap {
namespace {

// There are many links, each with the error of one picture: only together they tell more than the drive does.
constexpr double kLinkPrecision = 0.5;
constexpr int kMinIterations = 20;

}  // namespace

MapJoiner::MapJoiner(const SlamConfig& config, const MappingCamera& camera, const MapOverlap& overlap,
                     KeyFrameId last_of_target, bool with_scale, Map* map)
    : config_(config),
      camera_(camera),
      overlap_(overlap),
      last_of_target_(last_of_target),
      with_scale_(with_scale),
      map_(map) {}

void MapJoiner::MoveSource() {
  const Sim3& target_from_source = overlap_.target_from_source;
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> points;
  for (const auto& [id, point] : map_->points()) {
    if (!IsOfTarget(point.reference_keyframe))
      points.emplace_back(id, target_from_source * point.position_in_map);
  }
  for (const auto& [id, position] : points) map_->SetPosition(id, position);
  std::vector<std::pair<KeyFrameId, SE3>> keyframes;
  for (const auto& [id, keyframe] : map_->keyframes()) {
    if (IsOfTarget(id)) continue;
    const SE3 source_from_camera = keyframe.camera_from_map.Inverse();
    const SE3 target_from_camera(target_from_source.rigid.rotation() * source_from_camera.rotation(),
                                 target_from_source * source_from_camera.translation());
    keyframes.emplace_back(id, target_from_camera.Inverse());
  }
  for (const auto& [id, camera_from_target] : keyframes) {
    map_->SetPose(id, camera_from_target);
    if (target_from_source.scale != 1) map_->NoteRescaled(id, target_from_source.scale);
  }
}

void MapJoiner::Align(const std::atomic<bool>* stop) {
  MoveSource();
  const auto surest = std::max_element(overlap_.links.begin(), overlap_.links.end(),
                                       [](const Loop& a, const Loop& b) { return a.inliers < b.inliers; });
  map_->GraftTree(surest->current, surest->old);
  EssentialGraph graph(config_.loop.pose_graph_min_shared, with_scale_, *map_);
  for (Loop link : overlap_.links) {
    // The source has the target's unit now.
    link.old_from_current.scale =
        with_scale_ ? link.old_from_current.scale / overlap_.target_from_source.scale : 1;
    graph.AddLoop(link, kLinkPrecision);
  }
  PoseGraphOptions options;
  options.max_iterations = config_.loop.pose_graph_iterations;
  options.stop = stop;
  graph.Optimize(options);
  graph.WriteBack(map_);
  for (const auto& [id, point] : map_->points()) map_->UpdateViewing(id);
}

int MapJoiner::Fuse(const StepVisitor& visit) {
  const size_t before = map_->points().size();
  for (size_t i = 0; i < overlap_.links.size(); ++i) {
    if (visit && !visit(static_cast<double>(i) / static_cast<double>(overlap_.links.size()))) break;
    FuseLoopEnds(camera_, overlap_.links[i], map_);
  }
  for (const auto& [id, point] : map_->points()) map_->UpdateViewing(id);
  // Each pair that became one point is one point less.
  return static_cast<int>(before - map_->points().size());
}

BundleSummary MapJoiner::Adjust(const std::atomic<bool>* stop) {
  LoopConfig loop = config_.loop;
  loop.full_iterations = std::max(loop.full_iterations, kMinIterations);
  FullBundle bundle(loop, camera_.model, *map_);
  const BundleSummary summary = bundle.Solve(stop);
  if (!summary.stopped) bundle.Apply(map_);
  return summary;
}

ReprojectionError MapJoiner::MeasureSeam() const {
  return MeasureReprojection(*map_, camera_.model, [this](const MapPoint& point) {
    const auto is_of_target = [this](const Observation& seen) { return IsOfTarget(seen.keyframe); };
    const auto count = std::count_if(point.observations.begin(), point.observations.end(), is_of_target);
    return count > 0 && count < static_cast<std::ptrdiff_t>(point.observations.size());
  });
}

}  // namespace semmap
