#include "client/cli/drive_report.h"

#include "absl/strings/str_format.h"
#include "client/names.h"
#include "slam/evaluation/statistics.h"

namespace semmap::client {

nlohmann::json DriveJson(const PlayResult& result, const DriveMonitor::Latencies& latencies,
                         const std::string& trajectory_file) {
  const v1::Session& session = result.summary.session();
  const v1::SessionStatistics& statistics = session.statistics();
  const double share = result.frames > 0 ? static_cast<double>(statistics.frames_tracked()) /
                                               static_cast<double>(result.frames)
                                         : 0.0;
  const double fps = result.duration_s > 0 ? static_cast<double>(result.frames) / result.duration_s : 0.0;
  return {
      {"frames", result.frames},
      {"tracked", statistics.frames_tracked()},
      {"tracked_share", share},
      {"dropped", statistics.frames_dropped()},
      {"classified", statistics.frames_classified()},
      {"unclassified", statistics.frames_unclassified()},
      {"keyframes", statistics.keyframes()},
      {"points", statistics.points()},
      {"resumes", statistics.resumes()},
      {"median_ms", Percentile(latencies.answer_ms, 0.5)},
      {"p95_ms", Percentile(latencies.answer_ms, 0.95)},
      {"track_median_ms", Percentile(latencies.track_ms, 0.5)},
      {"track_p95_ms", Percentile(latencies.track_ms, 0.95)},
      {"duration_s", result.duration_s},
      {"finish_s", result.finish_s},
      {"fps", fps},
      {"interrupted", result.interrupted},
      {"map", IdOfName(session.map())},
      {"session", IdOfName(session.name())},
      {"vehicle", session.vehicle_id()},
      {"trajectory", trajectory_file.empty() ? nlohmann::json(nullptr) : nlohmann::json(trajectory_file)}};
}

std::string DriveTable(const nlohmann::json& summary) {
  const auto number = [&summary](const char* key) { return summary[key].get<double>(); };
  const auto count = [&summary](const char* key) { return summary[key].get<int64_t>(); };
  std::string table = absl::StrFormat(
      "map         %s\n"
      "session     %s\n"
      "frames      %d, tracked %d (%.1f %%), dropped %d\n"
      "map size    %d keyframes, %d points\n"
      "answer      %.1f ms median, %.1f ms 95th percentile\n"
      "tracking    %.1f ms median, %.1f ms 95th percentile (on the server)\n"
      "duration    %.1f s, %.1f frames/s; stored %.1f s later\n"
      "trajectory  %s\n",
      summary["map"].get<std::string>(), summary["session"].get<std::string>(), count("frames"),
      count("tracked"), 100 * number("tracked_share"), count("dropped"), count("keyframes"), count("points"),
      number("median_ms"), number("p95_ms"), number("track_median_ms"), number("track_p95_ms"),
      number("duration_s"), number("fps"), number("finish_s"),
      summary["trajectory"].is_null() ? "-" : summary["trajectory"].get<std::string>());
  if (count("classified") + count("unclassified") > 0) {
    absl::StrAppendFormat(&table, "classes     of %d frames, missed for %d\n", count("classified"),
                          count("unclassified"));
  }
  if (summary.contains("ate_rmse_m")) {
    absl::StrAppendFormat(&table, "error       %.4f m RMSE, %.4f m at most, %d poses, aligned: %s\n",
                          number("ate_rmse_m"), number("ate_max_m"), count("ate_poses"),
                          summary["ate_alignment"].get<std::string>());
  }
  return table;
}

void AddTruth(const AteResult& ate, SensorType sensor, nlohmann::json* summary) {
  (*summary)["ate_rmse_m"] = ate.translation_m.rmse;
  (*summary)["ate_max_m"] = ate.translation_m.max;
  (*summary)["ate_poses"] = ate.errors_m.size();
  (*summary)["ate_alignment"] = DriveAlignment(sensor) == Alignment::kSim3 ? "sim3" : "se3";
}

}  // namespace semmap::client
