// ATE, RPE, MAPE and recall against values worked out by hand.

#include <numbers>

#include <gtest/gtest.h>

#include "slam/evaluation/ate.h"
#include "slam/evaluation/mape.h"
#include "slam/evaluation/recall.h"
#include "slam/evaluation/rpe.h"
#include "tests/unit/evaluation/evaluation_test_util.h"

namespace semmap {
namespace {

SE3 SomeMotion() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized())), {10, -20, 5}};
}

// `trajectory` seen from another map frame and in another scale.
Trajectory Transformed(const Trajectory& trajectory, const SE3& new_from_old, double scale) {
  Trajectory result = trajectory;
  for (StampedPose& pose : result.poses) {
    const SE3 moved = new_from_old * pose.map_from_camera;
    pose.map_from_camera = SE3(moved.rotation(), scale * moved.translation());
  }
  return result;
}

TEST(Statistics, AgreeWithHandComputation) {
  const std::vector<double> errors = {3, 1, 2, 6};
  const ErrorStatistics statistics = Summarize(errors);
  EXPECT_EQ(statistics.count, 4U);
  EXPECT_DOUBLE_EQ(statistics.mean, 3.0);
  EXPECT_DOUBLE_EQ(statistics.median, 2.5);
  EXPECT_DOUBLE_EQ(statistics.rmse, std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(statistics.std, std::sqrt(3.5));
  EXPECT_DOUBLE_EQ(statistics.min, 1.0);
  EXPECT_DOUBLE_EQ(statistics.max, 6.0);
  EXPECT_DOUBLE_EQ(Percentile(errors, 1.0), 6.0);
  EXPECT_DOUBLE_EQ(Percentile(errors, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(Percentile({}, 0.5), 0.0);
}

TEST(Ate, RigidAlignmentUndoesARigidMotionOnly) {
  const Trajectory truth = BendTrajectory(100);
  EXPECT_LT(
      ComputeAte(PairUp(truth, Transformed(truth, SomeMotion(), 1.0)), Alignment::kSe3)->translation_m.max,
      1e-9);
  const auto pairs = PairUp(truth, Transformed(truth, SomeMotion(), 0.5));
  EXPECT_GT(ComputeAte(pairs, Alignment::kSe3)->translation_m.rmse, 1.0);
  const auto similar = ComputeAte(pairs, Alignment::kSim3);
  EXPECT_LT(similar->translation_m.max, 1e-9);
  EXPECT_NEAR(similar->reference_from_estimate.scale, 2.0, 1e-9);
}

TEST(Ate, WithoutAlignmentMeasuresThePlainDistance) {
  const Trajectory truth = BendTrajectory(20);
  Trajectory estimate = truth;
  for (StampedPose& pose : estimate.poses) {
    pose.map_from_camera =
        SE3(pose.map_from_camera.rotation(), pose.map_from_camera.translation() + Eigen::Vector3d(3, 0, 4));
  }
  const auto ate = ComputeAte(PairUp(truth, estimate), Alignment::kNone);
  EXPECT_NEAR(ate->translation_m.rmse, 5.0, 1e-12);
  EXPECT_EQ(ate->errors_m.size(), 20U);
}

TEST(Ate, RefusesWhatDeterminesNoAlignment) {
  EXPECT_FALSE(ComputeAte({}, Alignment::kNone).ok());
  EXPECT_FALSE(ComputeAte(PairUp(BendTrajectory(2), BendTrajectory(2)), Alignment::kSe3).ok());
}

// A straight road of one-metre steps, estimated `stretch` times as long and turning `yaw_rate` radians a
// metre.
std::vector<PosePair> StraightRoad(int metres, double stretch, double yaw_rate) {
  std::vector<PosePair> pairs;
  SE3 estimate;
  for (int i = 0; i <= metres; ++i) {
    PosePair pair;
    pair.timestamp = TimestampNs{i} * 100'000'000;
    pair.reference = SE3(Eigen::Quaterniond::Identity(), {0, 0, static_cast<double>(i)});
    pair.estimate = estimate;
    pairs.push_back(pair);
    estimate = estimate * SE3(Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rate, Eigen::Vector3d::UnitY())),
                              {0, 0, stretch});
  }
  return pairs;
}

TEST(SegmentRpe, MeasuresScaleDriftInPercent) {
  const auto rpe = ComputeSegmentRpe(StraightRoad(1000, 1.02, 0), {});
  ASSERT_TRUE(rpe.ok()) << rpe.status();
  ASSERT_EQ(rpe->by_length.size(), 8U);
  // A segment of "100 m" ends at the first pose beyond, 101 steps on.
  EXPECT_NEAR(rpe->by_length[0].translation_percent, 2.0 * 1.01, 1e-9);
  EXPECT_DOUBLE_EQ(rpe->by_length[7].length_m, 800.0);
  EXPECT_NEAR(rpe->rotation_deg_per_m, 0.0, 1e-9);
  // Starts every 10 poses from 0 to 899: (1000 - 101) / 10 + 1.
  EXPECT_EQ(rpe->by_length[0].segments, 90U);
}

TEST(SegmentRpe, MeasuresRotationPerMetre) {
  const double yaw_rate = 0.001;
  SegmentRpeOptions options;
  options.lengths_m = {99.5};
  const auto rpe = ComputeSegmentRpe(StraightRoad(300, 1.0, yaw_rate), options);
  ASSERT_TRUE(rpe.ok()) << rpe.status();
  EXPECT_NEAR(rpe->rotation_deg_per_m, 100 * yaw_rate * 180 / std::numbers::pi / 99.5, 1e-9);
}

TEST(SegmentRpe, ScaleOfTheAlignmentIsTakenOut) {
  SegmentRpeOptions options;
  options.estimate_scale = 0.5;
  EXPECT_NEAR(ComputeSegmentRpe(StraightRoad(300, 2.0, 0), options)->translation_percent, 0.0, 1e-9);
}

TEST(SegmentRpe, ShortPathsGetShortLengths) {
  const auto rpe = ComputeSegmentRpe(StraightRoad(60, 1.1, 0), {});
  ASSERT_TRUE(rpe.ok()) << rpe.status();
  EXPECT_DOUBLE_EQ(rpe->by_length.front().length_m, 10.0);
  EXPECT_DOUBLE_EQ(rpe->by_length.back().length_m, 50.0);
  EXPECT_EQ(rpe->by_length.front().segments, 50U);
}

TEST(SegmentRpe, RefusesNonsense) {
  SegmentRpeOptions options;
  options.lengths_m = {-1};
  EXPECT_FALSE(ComputeSegmentRpe(StraightRoad(60, 1, 0), options).ok());
  EXPECT_FALSE(ComputeSegmentRpe({}, {}).ok());
  options.lengths_m = {1000};
  EXPECT_EQ(ComputeSegmentRpe(StraightRoad(60, 1, 0), options).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(IntervalRpe, MeasuresDriftPerSecondAndPerFrames) {
  const auto pairs = StraightRoad(60, 1.1, 0.01);
  const auto by_time = ComputeIntervalRpe(pairs, {});
  IntervalRpeOptions frames;
  frames.delta_frames = 10;
  const auto by_frames = ComputeIntervalRpe(pairs, frames);
  ASSERT_TRUE(by_time.ok() && by_frames.ok());
  EXPECT_EQ(by_time->translation_m.count, 51U);
  EXPECT_DOUBLE_EQ(by_time->translation_m.rmse, by_frames->translation_m.rmse);
  EXPECT_NEAR(by_time->rotation_deg.mean, 0.1 * 180 / std::numbers::pi, 1e-9);
  frames.delta_frames = 100;
  EXPECT_FALSE(ComputeIntervalRpe(pairs, frames).ok());
  frames.delta_frames = -1;
  EXPECT_FALSE(ComputeIntervalRpe(pairs, frames).ok());
}

PosePair PairAt(const Eigen::Vector3d& truth, const Eigen::Vector3d& estimate) {
  PosePair pair;
  pair.reference = SE3(Eigen::Quaterniond::Identity(), truth);
  pair.estimate = SE3(Eigen::Quaterniond::Identity(), estimate);
  return pair;
}

TEST(Mape, AgreesWithHandComputation) {
  const std::vector<PosePair> pairs = {
      PairAt({0, 0, 0}, {1, 0, 1}),         // at the origin: left out on both axes
      PairAt({10, 0.2, 20}, {11, 9, 19}),   // 10 %, 5 %
      PairAt({20, 0.1, -40}, {20, 9, -42})  // 0 %, 5 %
  };
  MapeOptions options;
  options.alignment = Alignment::kNone;
  const auto mape = ComputeMape(pairs, options);
  ASSERT_TRUE(mape.ok()) << mape.status();
  EXPECT_EQ(mape->axes, (std::array<int, 2>{0, 2}));
  EXPECT_EQ(mape->left_out, (std::array<size_t, 2>{1, 1}));
  EXPECT_NEAR(mape->axis_percent[0], 5.0, 1e-12);
  EXPECT_NEAR(mape->axis_percent[1], 5.0, 1e-12);
  EXPECT_NEAR(mape->mape_percent, 5.0, 1e-12);
  EXPECT_NEAR(mape->errors_m[0], std::sqrt(2.0), 1e-12);
}

TEST(Mape, AlignsWithScaleByDefault) {
  const Trajectory truth = BendTrajectory(100);
  const auto mape = ComputeMape(PairUp(truth, Transformed(truth, SomeMotion(), 0.1)), {});
  ASSERT_TRUE(mape.ok()) << mape.status();
  EXPECT_NEAR(mape->mape_percent, 0.0, 1e-8);
}

TEST(Mape, RefusesAnAxisWithoutExtent) {
  const std::vector<PosePair> pairs = {PairAt({5, 0, 0}, {5, 0, 0}), PairAt({6, 0, 0}, {6, 0, 0})};
  MapeOptions options;
  options.alignment = Alignment::kNone;
  EXPECT_EQ(ComputeMape(pairs, options).status().code(), absl::StatusCode::kFailedPrecondition);
  options.axes = {{0, 0}};
  EXPECT_EQ(ComputeMape(pairs, options).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Recall, CountsUnansweredQueriesAsMisses) {
  const double degree = std::numbers::pi / 180;
  const std::vector<PoseError> errors = {{0.1, 1 * degree}, {0.1, 4 * degree}, {3, 1 * degree}};
  const std::vector<double> recall = RecallAtThresholds(errors, 4);
  EXPECT_EQ(recall, (std::vector<double>{0.25, 0.5, 0.75}));
  EXPECT_EQ(RecallAtThresholds({}, 0), (std::vector<double>{0, 0, 0}));
}

TEST(Recall, ComparesPosesWhateverTheMapFrame) {
  const SE3 pose = SomeMotion();
  const SE3 other =
      pose * SE3(Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX())), {0, 3, 4});
  EXPECT_NEAR(ComparePoses(pose, other).translation_m, 5.0, 1e-12);
  EXPECT_NEAR(ComparePoses(pose, other).rotation_rad, 0.2, 1e-12);
}

}  // namespace
}  // namespace semmap
