// Time per pose optimization and per bundle adjustment, on synthetic windows of the sizes that tracking and
// local mapping meet.
#include <benchmark/benchmark.h>

#include "slam/optimize/pose_optimizer.h"
#include "tests/unit/optimize/synthetic_scene.h"

namespace semmap {
namespace {

// Arguments: observations, per cent of them stereo.
void BM_OptimizePose(benchmark::State& state) {
  const PoseScene scene = MakePoseScene({.points = static_cast<int>(state.range(0)),
                                         .stereo_fraction = static_cast<double>(state.range(1)) / 100,
                                         .outlier_fraction = 0.1},
                                        1);
  std::mt19937 random(2);
  const SE3 initial = SE3::Exp(RandomTangent(0.1, 0.01, random)) * scene.camera_from_map;
  std::vector<char> outlier;
  for (auto _ : state) {
    benchmark::DoNotOptimize(OptimizePose(scene.model, initial, scene.observations, &outlier));
  }
}
BENCHMARK(BM_OptimizePose)
    ->ArgNames({"observations", "stereo"})
    ->Args({200, 0})
    ->Args({500, 0})
    ->Args({500, 100})
    ->Args({1500, 50})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace semmap

BENCHMARK_MAIN();
