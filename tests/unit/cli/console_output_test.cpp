// Tables, progress and names: what people see.

#include <gmock/gmock.h>

#include "client/cli/area_options.h"
#include "client/cli/class_names.h"
#include "client/cli/map_report.h"
#include "client/cli/progress.h"
#include "client/cli/server_options.h"
#include "client/cli/table.h"
#include "tests/unit/cli/cli_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

TEST(MapCheck, SaysSoundOrWhatIsWrong) {
  v1::CheckMapResponse response;
  response.set_keyframes(3);
  response.set_points(40);
  response.set_observations(100);
  EXPECT_THAT(MapCheckTable(response), HasSubstr("3 keyframes, 40 points, 100 observations\nsound\n"));
  EXPECT_EQ(MapCheckJson(response)["sound"], true);
  v1::MapProblem* problem = response.add_problems();
  problem->set_check("count-mismatch");
  problem->set_count(2);
  problem->set_detail("keyframe 7 has 5 observations, not 6");
  EXPECT_THAT(MapCheckTable(response), HasSubstr("count-mismatch      2  keyframe 7"));
  const nlohmann::json json = MapCheckJson(response);
  EXPECT_EQ(json["sound"], false);
  EXPECT_EQ(json["problems"][0]["check"], "count-mismatch");
  EXPECT_EQ(json["problems"][0]["count"], 2);
}

TEST(Table, AlignsNumbersRightAndTextLeft) {
  Table table({"NAME", "N"});
  table.AddRow({"a", "5"});
  table.AddRow({"longer", "123"});
  EXPECT_EQ(table.Format(), "NAME      N\na         5\nlonger  123\n");
}

TEST(Table, FormatsTimesAndSizes) {
  EXPECT_EQ(FormatUtc(1311868164), "2011-07-28 15:49:24");
  EXPECT_EQ(FormatUtc(0), "-");
  EXPECT_EQ(FormatBytes(512), "512 B");
  EXPECT_EQ(FormatBytes(1536), "1.5 KiB");
  EXPECT_EQ(FormatBytes(int64_t{3} << 30), "3.0 GiB");
}

TEST(ClassNames, GoBothWays) {
  EXPECT_EQ(ClassName(7), "Road");
  EXPECT_EQ(ClassName(22), "Terrain");
  EXPECT_EQ(ClassName(255), "-");
  EXPECT_EQ(ClassName(99), "99");
  EXPECT_EQ(ParseClass("trafficlight"), 18U);
  EXPECT_EQ(ParseClass("7"), 7U);
  EXPECT_FALSE(ParseClass("dragon").has_value());
  EXPECT_FALSE(ParseClass("256").has_value());
}

DriveProgress HalfWay() {
  DriveProgress progress;
  progress.total = 100;
  progress.answered = 50;
  progress.tracking = "tracking";
  progress.latency_ms = 23.14;
  progress.frames_per_second = 9.8;
  progress.keyframes = 12;
  return progress;
}

TEST(Progress, ShowsTheBarAndTheFigures) {
  const std::string line = FormatProgress(HalfWay());
  EXPECT_THAT(line, HasSubstr("[############............] 50/100"));
  EXPECT_THAT(line, HasSubstr("9.8 fps"));
  EXPECT_THAT(line, HasSubstr("tracking"));
  EXPECT_THAT(line, HasSubstr("23.1 ms"));
  DriveProgress unknown = HalfWay();
  unknown.total.reset();
  EXPECT_THAT(FormatProgress(unknown), HasSubstr("50 frames"));
}

TEST(Progress, OverwritesItsLineOnATerminalOnly) {
  const auto start = ProgressLine::Clock::time_point() + std::chrono::hours(1);
  std::ostringstream out;
  std::ostringstream terminal;
  const Console console{out, terminal, true};
  ProgressLine line(console);
  for (int ms = 0; ms < 1000; ms += 10) line.Update(HalfWay(), start + std::chrono::milliseconds(ms));
  const std::string shown = terminal.str();
  const auto returns = std::count(shown.begin(), shown.end(), '\r');
  EXPECT_GE(returns, 4);
  EXPECT_LE(returns, 10);
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 0);

  std::ostringstream log;
  const Console plain{out, log, false};
  ProgressLine logged(plain);
  for (int s = 0; s < 25; ++s) logged.Update(HalfWay(), start + std::chrono::seconds(s));
  const std::string lines = log.str();
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 2);
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\r'), 0);
}

TEST(MapReport, SaysWhatAMapHolds) {
  v1::MapSummary summary;
  summary.mutable_map()->set_name("maps/town");
  summary.mutable_map()->set_state(v1::MAP_STATE_READY);
  summary.mutable_map()->set_keyframe_count(12);
  summary.set_trajectory_length_m(59.9);
  summary.mutable_point_extent()->mutable_max()->set_x(7.5);
  v1::ClassCount* roads = summary.add_classes();
  roads->set_semantic_class(7);
  roads->set_points(42);
  const std::string table = MapSummaryTable(summary);
  EXPECT_THAT(table, HasSubstr("town"));
  EXPECT_THAT(table, HasSubstr("x 0.0 to 7.5"));
  EXPECT_THAT(table, HasSubstr("Road"));
  const nlohmann::json json = MapSummaryJson(summary);
  EXPECT_EQ(json["name"], "town");
  EXPECT_EQ(json["keyframes"], 12);
  EXPECT_EQ(json["point_extent"]["max"][0], 7.5);
  EXPECT_TRUE(json["keyframe_extent"].is_null());
  EXPECT_EQ(json["classes"][0]["points"], 42);
}

TEST(AreaOptions, FillABoxOrASphereOrNothing) {
  v1::Area area;
  EXPECT_FALSE(FillArea({}, &area));
  EXPECT_TRUE(FillArea({{1, 2, 3, 4, 5, 6}, {}, {}, {}}, &area));
  EXPECT_EQ(area.box().max().y(), 5);
  EXPECT_TRUE(FillArea({{}, {1, 2, 3, 9}, {}, {}}, &area));
  EXPECT_EQ(area.sphere().center().z(), 3);
  EXPECT_EQ(area.sphere().radius_m(), 9);
}

using ServerOptionsTest = CliTest;

TEST_F(ServerOptionsTest, CertificateAndKeyBelongTogether) {
  ServerOptions options;
  options.tls_cert = WriteText("cert.pem", "x");
  EXPECT_EQ(ExitCodeOf(Connect(options).status()), kExitUsage);
  options.tls_key = Path("missing.pem");
  EXPECT_EQ(Connect(options).status().code(), absl::StatusCode::kNotFound);
}

TEST(ExitCodes, TellUsageFromFailure) {
  EXPECT_EQ(ExitCodeOf(absl::OkStatus()), 0);
  EXPECT_EQ(ExitCodeOf(absl::InvalidArgumentError("x")), 1);
  EXPECT_EQ(ExitCodeOf(UsageError("x")), 2);
}

TEST(MapCommands, NeedAName) {
  for (const char* command : {"points", "keyframes", "trajectory"})
    EXPECT_EQ(RunProgram({command}).exit_code, 2);
  EXPECT_EQ(RunProgram({"map"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"map", "show"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"points", "m", "--box", "1", "2"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"points", "m", "--class", "dragon"}).exit_code, 2);
}

}  // namespace
}  // namespace semmap::client
