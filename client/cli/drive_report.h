#pragma once

#include <string>

#include "client/cli/drive_runner.h"
#include "nlohmann/json.hpp"
#include "slam/evaluation/ate.h"
#include "slam/geometry/camera.h"

namespace semmap::client {

// Summary of a drive: frames, tracked, tracked_share, keyframes, points, dropped, median_ms, p95_ms (from
// sending a frame to its answer), the server's own track times, duration_s, fps, map, session, trajectory
// (file name or null).
nlohmann::json DriveJson(const PlayResult& result, const DriveMonitor::Latencies& latencies,
                         const std::string& trajectory_file);

// One camera cannot know the scale.
inline Alignment DriveAlignment(SensorType sensor) {
  return sensor == SensorType::kMono ? Alignment::kSim3 : Alignment::kSe3;
}

// Adds to a summary how far the trajectory is from the truth: ate_rmse_m, ate_max_m, ate_poses,
// ate_alignment.
void AddTruth(const AteResult& ate, SensorType sensor, nlohmann::json* summary);

// The same for people.
std::string DriveTable(const nlohmann::json& summary);

}  // namespace semmap::client
