#pragma once

#include <string>

#include "client/cli/drive_runner.h"
#include "nlohmann/json.hpp"

namespace semmap::client {

// Summary of a drive: frames, tracked, keyframes, points, dropped, median_ms, p95_ms (from sending a frame to
// its answer), the server's own track times, duration_s, fps, map, session, trajectory (file name or null).
nlohmann::json DriveJson(const PlayResult& result, const DriveMonitor::Latencies& latencies,
                         const std::string& trajectory_file);

// The same for people.
std::string DriveTable(const nlohmann::json& summary);

}  // namespace semmap::client
