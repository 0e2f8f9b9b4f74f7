#include "client/cli/eval_report.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace semmap::client {
namespace {

using Json = nlohmann::json;

constexpr char kAxisNames[] = "xyz";

Json StatisticsJson(const ErrorStatistics& statistics) {
  return {{"rmse", statistics.rmse}, {"mean", statistics.mean}, {"median", statistics.median},
          {"max", statistics.max},   {"min", statistics.min},   {"std", statistics.std}};
}

// What every metric says about its input.
Json CommonJson(const char* metric, const EvalOptions& options, const EvalInput& input, double scale) {
  return {{"metric", metric},
          {"align", AlignmentName(options.alignment)},
          {"associated_by", input.by_time ? "time" : "index"},
          {"pairs", input.pairs.size()},
          {"reference_poses", input.reference.size()},
          {"estimate_poses", input.estimate.size()},
          {"reference_length_m", PathLength(input.reference)},
          {"scale", scale}};
}

Json TransformJson(const Sim3& transform) {
  const Eigen::Vector3d& t = transform.rigid.translation();
  const Eigen::Quaterniond& q = transform.rigid.rotation();
  return {{"translation", {t.x(), t.y(), t.z()}}, {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

std::string Row(const char* name, double value, const char* unit) {
  return absl::StrFormat("%-10s %14.6f %s\n", name, value, unit);
}

std::string StatisticsRows(const ErrorStatistics& statistics, const char* unit) {
  return absl::StrCat(Row("rmse", statistics.rmse, unit), Row("mean", statistics.mean, unit),
                      Row("median", statistics.median, unit), Row("max", statistics.max, unit),
                      Row("min", statistics.min, unit), Row("std", statistics.std, unit));
}

std::string InputRows(const EvalInput& input, double scale) {
  return absl::StrFormat("%-10s %14d of %d reference and %d estimated poses, by %s\n%-10s %14.6f\n", "pairs",
                         input.pairs.size(), input.reference.size(), input.estimate.size(),
                         input.by_time ? "time" : "index", "scale", scale);
}

}  // namespace

Json AteJson(const EvalOptions& options, const EvalInput& input, const AteResult& ate) {
  Json result = CommonJson("ate", options, input, ate.reference_from_estimate.scale);
  result.update(StatisticsJson(ate.translation_m));
  result["reference_from_estimate"] = TransformJson(ate.reference_from_estimate);
  return result;
}

std::string AteTable(const EvalOptions& options, const EvalInput& input, const AteResult& ate) {
  return absl::StrCat("Absolute trajectory error, aligned: ", AlignmentName(options.alignment), "\n",
                      StatisticsRows(ate.translation_m, "m"),
                      InputRows(input, ate.reference_from_estimate.scale));
}

Json RpeJson(const EvalOptions& options, const EvalInput& input, const RpeResult& rpe) {
  Json result = CommonJson("rpe", options, input, rpe.scale);
  result.update(StatisticsJson(rpe.interval.translation_m));
  result["rotation_deg"] = StatisticsJson(rpe.interval.rotation_deg);
  result["intervals"] = rpe.interval.translation_m.count;
  if (rpe.interval_options.delta_frames > 0) {
    result["delta_frames"] = rpe.interval_options.delta_frames;
  } else {
    result["delta_s"] = rpe.interval_options.delta_s;
  }
  result["segments"] = nullptr;
  if (!rpe.segments) return result;
  Json lengths = Json::array();
  for (const SegmentLengthError& length : rpe.segments->by_length) {
    lengths.push_back({{"length_m", length.length_m},
                       {"segments", length.segments},
                       {"translation_percent", length.translation_percent},
                       {"rotation_deg_per_m", length.rotation_deg_per_m}});
  }
  result["segments"] = {{"count", rpe.segments->segments},
                        {"translation_percent", rpe.segments->translation_percent},
                        {"rotation_deg_per_m", rpe.segments->rotation_deg_per_m},
                        {"by_length", lengths}};
  return result;
}

std::string RpeTable(const EvalInput& input, const RpeResult& rpe) {
  const std::string interval =
      rpe.interval_options.delta_frames > 0
          ? absl::StrCat(rpe.interval_options.delta_frames,
                         rpe.interval_options.delta_frames == 1 ? " frame" : " frames")
          : absl::StrCat(rpe.interval_options.delta_s, " s");
  std::string table =
      absl::StrCat("Relative pose error over ", interval, "; translation\n",
                   StatisticsRows(rpe.interval.translation_m, "m"), "rotation\n",
                   StatisticsRows(rpe.interval.rotation_deg, "deg"), InputRows(input, rpe.scale));
  if (!rpe.segments) return absl::StrCat(table, "The path is too short for KITTI's segments.\n");
  absl::StrAppendFormat(&table, "\n%10s %10s %14s %14s\n", "length m", "segments", "translation %",
                        "rotation deg/m");
  for (const SegmentLengthError& length : rpe.segments->by_length) {
    absl::StrAppendFormat(&table, "%10.1f %10d %14.4f %14.6f\n", length.length_m, length.segments,
                          length.translation_percent, length.rotation_deg_per_m);
  }
  absl::StrAppendFormat(&table, "%10s %10d %14.4f %14.6f\n", "all", rpe.segments->segments,
                        rpe.segments->translation_percent, rpe.segments->rotation_deg_per_m);
  return table;
}

Json MapeJson(const EvalOptions& options, const EvalInput& input, const MapeResult& mape) {
  Json result = CommonJson("mape", options, input, mape.reference_from_estimate.scale);
  result.update(StatisticsJson(Summarize(mape.errors_m)));
  result["mape_percent"] = mape.mape_percent;
  for (size_t i = 0; i < 2; ++i) {
    result["axes"].push_back({{"axis", std::string(1, kAxisNames[mape.axes[i]])},
                              {"percent", mape.axis_percent[i]},
                              {"used", mape.used[i]},
                              {"left_out", mape.left_out[i]}});
  }
  return result;
}

std::string MapeTable(const EvalInput& input, const MapeResult& mape) {
  std::string table = Row("mape", mape.mape_percent, "%");
  for (size_t i = 0; i < 2; ++i) {
    absl::StrAppendFormat(&table, "%-10c %14.6f %% of %d coordinates, %d too near to zero\n",
                          kAxisNames[mape.axes[i]], mape.axis_percent[i], mape.used[i], mape.left_out[i]);
  }
  return absl::StrCat("Mean absolute percentage error of the ground position\n", table,
                      StatisticsRows(Summarize(mape.errors_m), "m"),
                      InputRows(input, mape.reference_from_estimate.scale));
}

}  // namespace semmap::client
