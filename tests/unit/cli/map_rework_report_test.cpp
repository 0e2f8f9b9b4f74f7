#include "client/cli/map_rework_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli_test_util.h"

namespace semmap::client {
namespace {

using testing::HasSubstr;

v1::MergeMapsResponse Merged() {
  v1::MergeMapsResponse response;
  response.mutable_map()->set_name("maps/town");
  response.mutable_map()->set_keyframe_count(120);
  response.mutable_map()->set_point_count(9000);
  response.mutable_target_from_source()->set_scale(0.5);
  response.mutable_target_from_source()->mutable_pose()->mutable_translation()->set_x(12.25);
  // A quarter turn.
  response.mutable_target_from_source()->mutable_pose()->mutable_rotation()->set_y(0.70710678118654757);
  response.mutable_target_from_source()->mutable_pose()->mutable_rotation()->set_w(0.70710678118654757);
  response.set_overlapping_keyframes(17);
  response.set_fused_points(1234);
  response.set_reprojection_rms_px(0.875);
  return response;
}

TEST(MapReworkReport, MergeSaysHowTheMapsLie) {
  const nlohmann::json json = MergeJson(Merged(), true);
  EXPECT_EQ(json["dry_run"], true);
  EXPECT_EQ(json["map"]["name"], "town");
  EXPECT_EQ(json["overlapping_keyframes"], 17);
  EXPECT_EQ(json["fused_points"], 1234);
  EXPECT_EQ(json["reprojection_rms_px"].get<double>(), 0.875);
  EXPECT_EQ(json["target_from_source"]["scale"].get<double>(), 0.5);
  EXPECT_EQ(json["target_from_source"]["translation"][0].get<double>(), 12.25);
  const std::string table = MergeTable(Merged(), false);
  EXPECT_THAT(table, HasSubstr("17 keyframes"));
  EXPECT_THAT(table, HasSubstr("12.250 0.000 0.000, turned by 90.00 degrees, scaled by 0.50000"));
  EXPECT_THAT(table, HasSubstr("holds       town, 120 keyframes, 9000 points"));
  EXPECT_THAT(MergeTable(Merged(), true), HasSubstr("0.88 px RMS before adjustment"));
}

TEST(MapReworkReport, OptimizeAndPrune) {
  Client::Optimized optimized;
  optimized.map.set_name("maps/town");
  optimized.report.set_initial_rms_px(2.5);
  optimized.report.set_final_rms_px(0.75);
  optimized.report.set_iterations(9);
  EXPECT_EQ(OptimizeJson(optimized)["final_rms_px"].get<double>(), 0.75);
  EXPECT_THAT(OptimizeTable(optimized), HasSubstr("0.750 px RMS, was 2.500"));
  Client::Pruned pruned;
  pruned.map.set_name("maps/town");
  pruned.map.set_keyframe_count(40);
  pruned.report.set_removed_keyframes(60);
  EXPECT_EQ(PruneJson(pruned, false)["removed_keyframes"], 60);
  EXPECT_THAT(PruneTable(pruned, true), HasSubstr("removes     60 keyframes"));
  EXPECT_THAT(PruneTable(pruned, false), HasSubstr("holds       town, 40 keyframes"));
}

TEST(MapReworkCommand, WrongCallsAreToldApart) {
  EXPECT_EQ(RunProgram({"map", "merge", "town"}).exit_code, kExitUsage);
  EXPECT_EQ(RunProgram({"map", "optimize", "town", "--iterations", "-3"}).exit_code, kExitUsage);
  EXPECT_EQ(RunProgram({"map", "prune", "town"}).exit_code, kExitUsage);
  EXPECT_EQ(RunProgram({"map", "prune", "town", "--max-points", "-1"}).exit_code, kExitUsage);
}

}  // namespace
}  // namespace semmap::client
