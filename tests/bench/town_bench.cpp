// Speed of the simulated town: `town_bench` prints frames a second of a whole drive (simulation, image with
// mask and depth, sensors) in items_per_second; 15 are asked for at 800x600 on two cores. The CPU column
// counts all threads.
#include <benchmark/benchmark.h>

#include <memory>

#include "client/town/drive.h"

namespace {

using semmap::town::DriveConfig;
using semmap::town::DriveFrame;
using semmap::town::TownDrive;

void DriveRoute(benchmark::State& state, bool stereo, int vehicles, int pedestrians) {
  DriveConfig config;
  config.stereo = stereo;
  config.traffic = {vehicles, pedestrians};
  config.max_frames = 1 << 20;
  auto drive = TownDrive::Create(config);
  if (!drive.ok()) {
    state.SkipWithError(drive.status().ToString().c_str());
    return;
  }
  DriveFrame frame;
  constexpr int kStride = 10;  // see many places in little time: nine of ten frames are not counted
  for (auto _ : state) {
    state.PauseTiming();
    for (int i = 1; i < kStride; ++i) (*drive)->Skip();
    state.ResumeTiming();
    auto more = (*drive)->Next(&frame);
    if (!more.ok() || !*more) {
      state.SkipWithError("the drive ended");
      break;
    }
  }
  state.SetItemsProcessed(state.iterations());
  state.SetLabel((*drive)->device());
}

void BM_MonocularDrive(benchmark::State& state) { DriveRoute(state, false, 20, 10); }
void BM_StereoDrive(benchmark::State& state) { DriveRoute(state, true, 20, 10); }
void BM_EmptyStreets(benchmark::State& state) { DriveRoute(state, false, 0, 0); }

BENCHMARK(BM_MonocularDrive)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(60)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(BM_StereoDrive)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(60)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(BM_EmptyStreets)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(60)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
