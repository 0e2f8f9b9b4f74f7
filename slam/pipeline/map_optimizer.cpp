#include "slam/pipeline/map_optimizer.h"

#include "slam/pipeline/full_bundle.h"
#include "slam/pipeline/reprojection_error.h"

namespace semmap {
namespace {

size_t CountObservations(const Map& map) {
  size_t count = 0;
  for (const auto& [id, point] : map.points()) count += point.observations.size();
  return count;
}

}  // namespace

OptimizeResult OptimizeWholeMap(int max_iterations, const MappingCamera& camera,
                                const std::atomic<bool>* stop, Map* map) {
  OptimizeResult result;
  result.initial_rms_px = MeasureReprojection(*map, camera.model).rms_px;
  const size_t before = CountObservations(*map);
  LoopConfig config;
  config.full_iterations = max_iterations;
  FullBundle bundle(config, camera.model, *map);
  const BundleSummary summary = bundle.Solve(stop);
  result.iterations = summary.iterations;
  result.stopped = summary.stopped;
  if (!summary.stopped) bundle.Apply(map);
  result.final_rms_px = MeasureReprojection(*map, camera.model).rms_px;
  result.removed_observations = before - CountObservations(*map);
  return result;
}

}  // namespace semmap
