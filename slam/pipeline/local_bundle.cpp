#include "slam/pipeline/local_bundle.h"

#include "slam/pipeline/map_window.h"

namespace semmap {
namespace {

constexpr int kMinSharedPoints = 15;

BundleOptions MakeOptions(const MappingConfig& config, const std::atomic<bool>* stop) {
  BundleOptions options;
  options.first_iterations = config.bundle_iterations;
  options.second_iterations = config.bundle_iterations_refined;
  options.stop = stop;
  return options;
}

}  // namespace

BundleSummary AdjustLocalMap(const MappingConfig& config, const ProjectionModel& model, KeyFrameId keyframe,
                             const std::atomic<bool>* stop, Map* map) {
  MapWindow window(model);
  const auto limit = static_cast<size_t>(config.max_local_keyframes);
  std::vector<KeyFrameId> free = {keyframe};
  for (const CovisibleKeyFrame& neighbour : map->BestCovisible(keyframe, limit - 1, kMinSharedPoints)) {
    free.push_back(neighbour.id);
  }
  for (const KeyFrameId id : free) window.AddCamera(*map, id, !map->FindKeyFrame(id)->parent.IsValid());
  for (const KeyFrameId id : free) window.AddPointsOf(*map, id);
  window.AddRim(*map, static_cast<size_t>(config.max_fixed_keyframes));
  window.FixOne();
  window.AddObservations(*map);
  const BundleSummary summary = window.Solve(MakeOptions(config, stop));
  window.WriteBack(map);
  return summary;
}

BundleSummary AdjustWholeMap(const MappingConfig& config, const ProjectionModel& model, Map* map) {
  MapWindow window = MapWindow::Whole(model, *map);
  BundleOptions options = MakeOptions(config, nullptr);
  options.second_iterations = 20;
  const BundleSummary summary = window.Solve(options);
  window.WriteBack(map);
  return summary;
}

}  // namespace semmap
