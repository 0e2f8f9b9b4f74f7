#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sources/frame_source.h"
#include "slam/evaluation/trajectory.h"
#include "slam/pipeline/frame.h"
#include "tests/bench/slam_bench_options.h"

namespace semmap::bench {

// Milliseconds of wall time, one entry a frame (`map`: one for each frame during which the mapper got
// further; with backlog 0 that is one for each keyframe).
struct StageSamples {
  std::vector<double> decode;
  std::vector<double> extract;
  std::vector<double> stereo;
  std::vector<double> classify;
  std::vector<double> match;
  std::vector<double> optimize;
  std::vector<double> track;
  std::vector<double> map;
  // cv::ORB on the left image, see UnitTimer.
  std::vector<double> unit;
  std::vector<double> unit_cpu;
};

// What one run over a recording gave.
struct RunResult {
  uint64_t frames = 0;
  uint64_t tracked = 0;
  int keyframes = 0;
  int points = 0;
  int loops = 0;
  int recoveries = 0;
  uint64_t classified = 0;
  uint64_t unclassified = 0;
  StageSamples stages;
  double wall_s = 0;
  // User and system time of all threads from the first frame to the end of mapping, decoding included, unit
  // excluded.
  double cpu_s = 0;
  double peak_rss_mb = 0;  // of the process so far
  // Size of the map's records in memory, for each keyframe (features, pose, observations) and each point.
  double bytes_per_keyframe = 0;
  double bytes_per_point = 0;
  // Against the recording's ground truth, if it has one: SE3 aligned, Sim3 for one camera.
  std::optional<double> ate_rmse_m;
  // Poses of the frames in the final map.
  Trajectory trajectory;
};

// The images of a frame as a session takes them; `with_colour`: for segmentation.
absl::StatusOr<FrameInput> DecodeFrame(const client::SourceFrame& frame, bool with_colour = false);

// Plays the recording through a Session in this process.
absl::StatusOr<RunResult> RunOnce(const BenchOptions& options);

}  // namespace semmap::bench
