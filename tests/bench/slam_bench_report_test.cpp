#include "tests/bench/slam_bench_report.h"

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "tests/bench/slam_bench_meters.h"

namespace semmap::bench {
namespace {

using ::testing::HasSubstr;

RunResult SomeRun(uint64_t tracked, std::vector<double> track_ms) {
  RunResult run;
  run.frames = 4;
  run.tracked = tracked;
  run.stages.track = std::move(track_ms);
  run.stages.unit = {10, 10, 10};
  run.stages.unit_cpu = {5, 5, 5};
  run.cpu_s = 0.2;
  run.keyframes = 2;
  run.points = 100;
  return run;
}

TEST(SlamBenchReport, HasTheFiguresThatScriptsRead) {
  const nlohmann::json report = ReportJson({SomeRun(4, {20, 30, 40, 50})});
  for (const char* key : {"frames", "tracked", "ate_rmse_m", "median_ms", "p95_ms", "unit_ms", "cpu_s",
                          "keyframes", "points", "peak_rss_mb"}) {
    EXPECT_TRUE(report.contains(key)) << key;
  }
  EXPECT_TRUE(report["ate_rmse_m"].is_null());
  EXPECT_DOUBLE_EQ(report["median_ms"], 35.0);
  EXPECT_DOUBLE_EQ(report["p95_ms"], 48.5);
  EXPECT_DOUBLE_EQ(report["unit_ms"], 10.0);
  EXPECT_DOUBLE_EQ(report["median_units"], 3.5);
  EXPECT_DOUBLE_EQ(report["cpu_units_per_frame"], 10.0);
  EXPECT_EQ(report["stages"]["track"]["count"], 4);
  EXPECT_FALSE(report.contains("runs"));
}

TEST(SlamBenchReport, SeveralRunsGiveMedians) {
  RunResult accurate = SomeRun(4, {20});
  accurate.ate_rmse_m = 0.1;
  RunResult poor = SomeRun(2, {40});
  poor.ate_rmse_m = 0.5;
  RunResult middle = SomeRun(3, {30});
  middle.ate_rmse_m = 0.2;
  const nlohmann::json report = ReportJson({accurate, poor, middle});
  EXPECT_EQ(report["tracked"], 3);
  EXPECT_DOUBLE_EQ(report["ate_rmse_m"], 0.2);
  EXPECT_DOUBLE_EQ(report["median_ms"], 30);
  EXPECT_EQ(report["runs"].size(), 3U);
  EXPECT_EQ(report["stages"]["track"]["count"], 3);
  const std::string table = ReportTable({accurate, poor, middle});
  EXPECT_THAT(table, HasSubstr("median of 3: frames 4, tracked 3, ATE 0.2000 m"));
  EXPECT_THAT(table, HasSubstr("optimize"));
}

TEST(UnitTimer, MeasuresAnEvenSampleOnOneThread) {
  cv::Mat image(240, 320, CV_8UC1);
  cv::randu(image, 0, 256);
  UnitTimer timer(200);
  const int threads = cv::getNumThreads();
  for (int i = 0; i < 200; ++i) timer.Offer(image);
  EXPECT_EQ(timer.milliseconds().size(), 50U);
  EXPECT_GT(timer.milliseconds().front(), 0.0);
  EXPECT_GT(timer.cpu_seconds(), 0.0);
  EXPECT_EQ(cv::getNumThreads(), threads);
}

TEST(MeasuringSink, CountsWhatTheMapHolds) {
  MeasuringSink sink;
  EXPECT_EQ(sink.BytesPerKeyFrame(), 0.0);
  MapDelta delta;
  for (const uint64_t id : {1, 2}) {
    KeyFrameRecord keyframe;
    keyframe.id = KeyFrameId(id);
    auto features = std::make_shared<FrameFeatures>();
    features->keypoints.resize(100 * id);
    features->descriptors.resize(100 * id);
    keyframe.features = features;
    delta.added_keyframes.push_back(keyframe);
  }
  MapPointRecord point;
  point.id = MapPointId(1);
  delta.upserted_points = {point};
  FramePose frame;
  frame.reference_keyframe = KeyFrameId(1);
  delta.frames = {frame};
  sink.OnDelta(delta);
  const double both = sink.BytesPerKeyFrame();
  EXPECT_GE(sink.BytesPerPoint(), sizeof(MapPointRecord));
  MapDelta removal;
  removal.removed_keyframes = {{KeyFrameId(2), KeyFrameId(1), SE3()}};
  removal.removed_points = {MapPointId(1)};
  sink.OnDelta(removal);
  EXPECT_LT(sink.BytesPerKeyFrame(), both);
  EXPECT_EQ(sink.BytesPerPoint(), 0.0);
  EXPECT_EQ(sink.collector().Compose().size(), 1U);
}

}  // namespace
}  // namespace semmap::bench
