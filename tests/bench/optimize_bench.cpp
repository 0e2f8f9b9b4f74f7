// Time per pose optimization and per bundle adjustment, on synthetic windows of the sizes that tracking and
// local mapping meet.
#include <benchmark/benchmark.h>

#include "slam/optimize/bundle_adjustment.h"
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

// Arguments: fixed and free cameras, points, observations, per cent of them stereo, threads, and whether the
// initial values are nearly right (warm), as when a keyframe joins an adjusted map.
void BM_AdjustBundle(benchmark::State& state) {
  BundleSceneOptions options = {.fixed_cameras = static_cast<int>(state.range(0)),
                                .free_cameras = static_cast<int>(state.range(1)),
                                .points = static_cast<int>(state.range(2)),
                                .observations = static_cast<int>(state.range(3)),
                                .stereo_fraction = static_cast<double>(state.range(4)) / 100,
                                .outlier_fraction = 0.03};
  if (state.range(6) != 0) {
    options.camera_error_m = 0.01;
    options.camera_error_rad = 0.0005;
    options.point_error_m = 0.03;
    options.outlier_fraction = 0.005;
  }
  const BundleScene scene = MakeBundleScene(options, 1);
  BundleSummary summary;
  for (auto _ : state) {
    state.PauseTiming();
    BundleProblem problem = scene.problem;
    state.ResumeTiming();
    summary = AdjustBundle({.threads = static_cast<int>(state.range(5))}, &problem);
  }
  state.counters["iterations"] = summary.iterations;
  state.counters["cost_ratio"] = summary.final_cost / summary.initial_cost;
  state.counters["outliers"] = summary.outliers;
}
BENCHMARK(BM_AdjustBundle)
    ->ArgNames({"fixed", "free", "points", "observations", "stereo", "threads", "warm"})
    ->Args({10, 6, 800, 4800, 0, 1, 1})
    ->Args({30, 20, 3000, 20000, 0, 1, 1})
    ->Args({30, 20, 3000, 20000, 0, 1, 0})
    ->Args({30, 20, 3000, 20000, 70, 1, 1})
    ->Args({30, 20, 3000, 20000, 70, 1, 0})
    ->Args({30, 20, 3000, 20000, 70, 2, 0})
    ->Args({1, 200, 15000, 90000, 50, 1, 0})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace semmap

BENCHMARK_MAIN();
