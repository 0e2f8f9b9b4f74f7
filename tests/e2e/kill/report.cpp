#include "report.h"

#include "absl/strings/str_cat.h"
#include "client/cli/table.h"

namespace semmap::kill_test {
namespace {

nlohmann::json TallyJson(const Tally& tally) {
  return {{"kills", tally.kills},
          {"inside", tally.inside},
          {"sound_maps", tally.maps},
          {"empty_maps", tally.empty},
          {"frames", tally.frames},
          {"keyframes", tally.keyframes},
          {"culled_keyframes", tally.culled},
          {"asked", tally.asked},
          {"found", tally.found},
          {"ended_sessions", tally.ended},
          {"failures", tally.failures}};
}

std::vector<std::string> Row(const std::string& name, const nlohmann::json& tally) {
  std::vector<std::string> row = {name};
  for (const char* column : {"kills", "inside", "sound_maps", "empty_maps", "frames", "keyframes", "asked",
                             "found", "ended_sessions"}) {
    row.push_back(absl::StrCat(tally[column].get<int>()));
  }
  row.push_back(absl::StrCat(tally["failures"].size()));
  return row;
}

}  // namespace

nlohmann::json ReportJson(const Rounds& rounds, uint64_t seed) {
  nlohmann::json phases;
  Tally all;
  for (const auto& [phase, tally] : rounds.tallies()) {
    phases[NameOf(phase)] = TallyJson(tally);
    all.Add(tally);
  }
  nlohmann::json report = {{"seed", seed},
                           {"phases", phases},
                           {"all", TallyJson(all)},
                           {"last_look", TallyJson(rounds.last_look())}};
  all.Add(rounds.last_look());
  report["failures"] = all.failures;
  return report;
}

std::string ReportTable(const nlohmann::json& report) {
  client::Table table({"killed in", "kills", "inside", "sound maps", "empty", "frames", "keyframes", "asked",
                       "found", "ended", "failures"});
  for (const auto& [name, tally] : report["phases"].items()) table.AddRow(Row(name, tally));
  table.AddRow(Row("all", report["all"]));
  table.AddRow(Row("last look", report["last_look"]));
  std::string text = table.Format();
  for (const nlohmann::json& failure : report["failures"])
    absl::StrAppend(&text, failure.get<std::string>(), "\n");
  return text;
}

}  // namespace semmap::kill_test
