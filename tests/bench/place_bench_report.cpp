#include "tests/bench/place_bench_report.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace semmap::bench {
namespace {

nlohmann::json RecallJson(const RecallResult& recall) {
  return {
      {"recording", recall.name},
      {"database", recall.database},
      {"queries", recall.queries},
      {"exact_recall_at_1", recall.exact.at_1},
      {"exact_recall_at_5", recall.exact.at_5},
      {"recall_at_1", recall.index.at_1},
      {"recall_at_5", recall.index.at_5},
      {"exact_best_in_best_5", recall.agreement},
      {"direct_index_matches_kept", recall.direct_matches},
      {"direct_index_comparisons", recall.direct_comparisons},
  };
}

nlohmann::json RowJson(const ScalingRow& row) {
  return {
      {"keyframes", row.keyframes},
      {"median_ms", row.median_ms},
      {"p95_ms", row.p95_ms},
      {"unbounded_median_ms", row.exact_median_ms},
      {"found", row.found},
      {"unbounded_found", row.exact_found},
      {"bytes_per_keyframe", row.bytes_per_keyframe},
      {"add_ms", row.add_ms},
  };
}

double Percent(double share) { return 100 * share; }

std::string RecallTable(const std::vector<RecallResult>& results) {
  std::string table =
      "| recording | database | queries | exact R@1 | R@5 | index R@1 | R@5 | exact best in index's 5 | "
      "direct: matches "
      "kept | of comparisons |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const RecallResult& r : results) {
    absl::StrAppendFormat(
        &table, "| %s | %d | %d | %.1f %% | %.1f %% | %.1f %% | %.1f %% | %.1f %% | %.1f %% | %.2f %% |\n",
        r.name, r.database, r.queries, Percent(r.exact.at_1), Percent(r.exact.at_5), Percent(r.index.at_1),
        Percent(r.index.at_5), Percent(r.agreement), Percent(r.direct_matches),
        Percent(r.direct_comparisons));
  }
  return table;
}

std::string ScalingTable(const ScalingResult& scaling) {
  std::string table =
      "| keyframes | query ms, median | p95 | unbounded ms | found | unbounded found | bytes a keyframe | "
      "add ms |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const ScalingRow& row : scaling.rows) {
    absl::StrAppendFormat(&table, "| %d | %.3f | %.3f | %.3f | %.1f %% | %.1f %% | %.0f | %.3f |\n",
                          row.keyframes, row.median_ms, row.p95_ms, row.exact_median_ms, Percent(row.found),
                          Percent(row.exact_found), row.bytes_per_keyframe, row.add_ms);
  }
  return table;
}

}  // namespace

nlohmann::json ReportJson(const PlaceReport& report) {
  nlohmann::json json = {
      {"vocabulary", report.vocabulary},
      {"vocabulary_bytes", report.vocabulary_bytes},
      {"words", report.words},
      {"load_ms", report.load_ms},
      {"recall", nlohmann::json::array()},
      {"retrieval", nlohmann::json::array()},
      {"describe_ms", report.scaling.describe_ms},
      {"descriptors", report.scaling.descriptors},
  };
  for (const RecallResult& recall : report.recall) json["recall"].push_back(RecallJson(recall));
  for (const ScalingRow& row : report.scaling.rows) json["retrieval"].push_back(RowJson(row));
  return json;
}

std::string ReportTables(const PlaceReport& report) {
  std::string text = absl::StrFormat("%s: %d words, %d bytes, loaded in %.2f ms\n", report.vocabulary,
                                     report.words, report.vocabulary_bytes, report.load_ms);
  if (!report.recall.empty()) absl::StrAppend(&text, "\n", RecallTable(report.recall));
  if (!report.scaling.rows.empty()) {
    absl::StrAppend(&text, "\n",
                    absl::StrFormat("describing %.0f descriptors: %.3f ms\n\n", report.scaling.descriptors,
                                    report.scaling.describe_ms),
                    ScalingTable(report.scaling));
  }
  return text;
}

}  // namespace semmap::bench
