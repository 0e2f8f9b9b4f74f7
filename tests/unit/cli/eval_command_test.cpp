#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "nlohmann/json.hpp"
#include "slam/evaluation/trajectory_io.h"
#include "tests/unit/cli/cli_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

class EvalCommand : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    const Trajectory truth = BendTrajectory(60);
    ASSERT_TRUE(WriteTrajectory(Path("truth.txt"), truth, TrajectoryFormat::kKitti).ok());
    ASSERT_TRUE(WriteTrajectory(Path("truth_tum.txt"), truth, TrajectoryFormat::kTum).ok());
    ASSERT_TRUE(WriteTrajectory(Path("half.txt"), BendTrajectory(60, 0.5), TrajectoryFormat::kTum).ok());
    std::string times;
    for (int i = 0; i < 60; ++i) times += std::to_string(0.1 * i) + "\n";
    WriteText("times.txt", times);
  }
};

TEST_F(EvalCommand, AteOfATumEstimateAgainstAKittiReference) {
  const Outcome outcome = RunProgram({"eval", "ate", "--reference", Path("truth.txt"), "--reference-format",
                                      "kitti", "--reference-times", Path("times.txt"), "--estimate",
                                      Path("half.txt"), "--format", "tum", "--align", "sim3", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto figures = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(figures["pairs"], 60);
  EXPECT_NEAR(figures["scale"].get<double>(), 2.0, 1e-9);
  for (const char* key : {"rmse", "mean", "median", "max", "std", "min"}) {
    EXPECT_NEAR(figures[key].get<double>(), 0.0, 1e-9) << key;
  }
  EXPECT_EQ(figures["associated_by"], "time");
}

TEST_F(EvalCommand, AlignmentMakesTheDifference) {
  const std::vector<std::string> base = {
      "eval", "ate", "--reference", Path("truth_tum.txt"), "--estimate", Path("half.txt"), "--json"};
  std::vector<double> rmse;
  for (const char* align : {"none", "se3", "sim3"}) {
    std::vector<std::string> arguments = base;
    arguments.insert(arguments.end(), {"--align", align});
    const Outcome outcome = RunProgram(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    rmse.push_back(nlohmann::json::parse(outcome.out)["rmse"]);
  }
  EXPECT_GT(rmse[0], rmse[1]);
  EXPECT_GT(rmse[1], 1.0);
  EXPECT_LT(rmse[2], 1e-9);
}

TEST_F(EvalCommand, WithoutJsonPrintsATable) {
  const Outcome outcome =
      RunProgram({"eval", "ate", "--reference", Path("truth_tum.txt"), "--estimate", Path("half.txt")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("rmse"));
  EXPECT_THAT(outcome.out, HasSubstr("60 of 60 reference and 60 estimated poses, by time"));
}

TEST_F(EvalCommand, RpeReportsSegmentsAndIntervals) {
  const Outcome outcome = RunProgram({"eval", "rpe", "--reference", Path("truth_tum.txt"), "--estimate",
                                      Path("half.txt"), "--align", "none", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto figures = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(figures["segments"]["by_length"][0]["length_m"], 10.0);
  EXPECT_NEAR(figures["segments"]["translation_percent"].get<double>(), 50.0, 6.0);
  EXPECT_NEAR(figures["rmse"].get<double>(), 5.0, 0.1);
  const Outcome scaled = RunProgram({"eval", "rpe", "--reference", Path("truth_tum.txt"), "--estimate",
                                     Path("half.txt"), "--align", "sim3", "--json"});
  EXPECT_NEAR(nlohmann::json::parse(scaled.out)["segments"]["translation_percent"].get<double>(), 0.0, 1e-6);
}

TEST_F(EvalCommand, MapeAlignsWithScale) {
  const Outcome outcome = RunProgram({"eval", "mape", "--reference", Path("truth_tum.txt"), "--estimate",
                                      Path("half.txt"), "--axes", "xz", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto figures = nlohmann::json::parse(outcome.out);
  EXPECT_NEAR(figures["mape_percent"].get<double>(), 0.0, 1e-8);
  EXPECT_EQ(figures["axes"][1]["axis"], "z");
}

TEST_F(EvalCommand, DrawsAPicture) {
  const Outcome outcome = RunProgram({"eval", "ate", "--reference", Path("truth_tum.txt"), "--estimate",
                                      Path("half.txt"), "--plot", Path("plot.png"), "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(nlohmann::json::parse(outcome.out).empty());
  const cv::Mat picture = cv::imread(Path("plot.png"));
  EXPECT_EQ(picture.size(), cv::Size(1200, 1200));
}

TEST_F(EvalCommand, UsageErrorsExitWithTwo) {
  const std::string truth = Path("truth.txt");
  const std::string half = Path("half.txt");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {},
           {"eval"},
           {"nonsense"},
           {"eval", "ate"},
           {"eval", "ate", "--reference", truth, "--estimate", half, "--align", "affine"},
           {"eval", "ate", "--reference", truth, "--reference-format", "kitti", "--estimate", half},
           {"eval", "ate", "--reference", half, "--estimate", truth, "--format", "kitti"},
           {"drive", "--source", "rosbag:x", "--sensor", "mono", "--map", "m", "--vehicle", "v"},
       }) {
    const Outcome outcome = RunProgram(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << ::testing::PrintToString(arguments);
    EXPECT_FALSE(outcome.err.empty());
    EXPECT_TRUE(outcome.out.empty()) << outcome.out;
  }
}

TEST_F(EvalCommand, FailuresExitWithOneAndLeaveStdoutEmpty) {
  WriteText("short.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"eval", "ate", "--reference", "/no/such/file", "--estimate", Path("half.txt"), "--json"},
           {"eval", "ate", "--reference", Path("truth.txt"), "--reference-format", "kitti", "--estimate",
            Path("short.txt"), "--format", "kitti", "--json"},
           {"eval", "ate", "--reference", Path("truth_tum.txt"), "--estimate", Path("half.txt"), "--plot",
            "/no/such/folder/plot.png"},
       }) {
    const Outcome outcome = RunProgram(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << ::testing::PrintToString(arguments);
    EXPECT_TRUE(outcome.out.empty());
    EXPECT_THAT(outcome.err, HasSubstr("semmap: "));
  }
}

TEST_F(EvalCommand, HelpExitsWithZero) {
  EXPECT_EQ(RunProgram({"--help"}).exit_code, 0);
  EXPECT_THAT(RunProgram({"eval", "ate", "--help"}).out, HasSubstr("--reference-times"));
}

TEST_F(EvalCommand, ReproducesThePublishedFigures) {
  const std::string folder = SharedDataFolder() + "/trajectories/";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no shared trajectories at " << folder;
  Outcome outcome = RunProgram({"eval", "ate", "--reference", folder + "KITTI_00_gt.txt",
                                "--reference-format", "kitti", "--estimate", folder + "KITTI_00_ORB.txt",
                                "--format", "kitti", "--align", "se3", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(nlohmann::json::parse(outcome.out)["rmse"].get<double>(), 1.303, 0.0005);
  outcome = RunProgram({"eval", "ate", "--reference", folder + "fr2_desk_groundtruth.txt",
                        "--reference-format", "tum", "--estimate", folder + "fr2_desk_ORB.txt", "--format",
                        "tum", "--align", "se3", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(nlohmann::json::parse(outcome.out)["rmse"].get<double>(), 0.0081, 0.00005);
}

}  // namespace
}  // namespace semmap::client
