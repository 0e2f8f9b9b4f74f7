// A whole session in a room through which something big moves, with class masks that say so.
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "slam/evaluation/ate.h"
#include "slam/evaluation/trajectory_collector.h"
#include "slam/pipeline/session.h"
#include "tests/support/contents_collector.h"
#include "tests/support/room_drive.h"
#include "tests/support/textured_room.h"

namespace semmap {
namespace {

using ::semmap::testing::ContentsCollector;
using ::semmap::testing::DriveThroughRoom;
using ::semmap::testing::GentleDrive;
using ::semmap::testing::SmallRig;

constexpr int kFrames = 24;
constexpr double kStep = 0.12;
constexpr uint8_t kBuilding = 1;
constexpr uint8_t kVehicles = 10;

// A lorry's tailgate in front of the camera: it keeps its distance, and drifts to the side.
cv::Rect TailgateAt(int index) { return {60 + 6 * index, 90, 190, 190}; }

cv::Mat Tailgate(const cv::Size& size) {
  cv::Mat coarse(size.height / 10, size.width / 10, CV_8UC1);
  cv::RNG random(4);
  random.fill(coarse, cv::RNG::UNIFORM, 20, 236);
  cv::Mat texture;
  cv::resize(coarse, texture, size, 0, 0, cv::INTER_NEAREST);
  return texture;
}

std::vector<FrameInput> MakeDrive() {
  std::vector<FrameInput> frames = DriveThroughRoom(SensorType::kRgbd, kFrames, kStep);
  for (int i = 0; i < kFrames; ++i) {
    FrameInput& frame = frames[static_cast<size_t>(i)];
    frame.class_mask = cv::Mat(frame.image.size(), CV_8UC1, cv::Scalar(kBuilding));
    const cv::Rect tailgate = TailgateAt(i);
    Tailgate(tailgate.size()).copyTo(frame.image(tailgate));
    frame.depth(tailgate) = 3.0F;
    frame.class_mask(tailgate) = kVehicles;
  }
  return frames;
}

const std::vector<FrameInput>& Drive() {
  static const std::vector<FrameInput> frames = MakeDrive();
  return frames;
}

class Collector : public ContentsCollector {
 public:
  void OnDelta(MapDelta delta) override {
    ContentsCollector::OnDelta(delta);
    trajectory.OnDelta(std::move(delta));
  }

  TrajectoryCollector trajectory;
};

class SemanticSessionTest : public ::testing::TestWithParam<SensorType> {
 protected:
  SemanticSessionTest() {
    config_.orb.features = 800;
    config_.deterministic = true;
  }

  // Returns the error of the trajectory.
  double Run(const std::function<void(FrameInput*)>& change = [](FrameInput*) {}) {
    collector_ = std::make_unique<Collector>();
    auto session = Session::Create(config_, SmallRig(GetParam()), collector_.get(), nullptr);
    EXPECT_TRUE(session.ok()) << session.status();
    for (FrameInput frame : Drive()) {
      if (GetParam() == SensorType::kMono) frame.depth.release();
      change(&frame);
      const auto answer = (*session)->Track(frame);
      EXPECT_TRUE(answer.ok()) << answer.status();
    }
    (*session)->Finish();
    return Error();
  }

  double Error() const {
    Trajectory truth;
    const std::vector<SE3> poses = GentleDrive(kFrames, kStep);
    for (int i = 0; i < kFrames; ++i) truth.poses.push_back({FromSeconds(0.1 * i), poses[i]});
    const auto pairs = AssociateByTime(truth, collector_->trajectory.Compose());
    if (!pairs.ok()) return 1e9;
    const auto ate = ComputeAte(*pairs, GetParam() == SensorType::kMono ? Alignment::kSim3 : Alignment::kSe3);
    return ate.ok() ? ate->translation_m.rmse : 1e9;
  }

  std::vector<SE3> Poses() const {
    std::vector<SE3> poses;
    for (const StampedPose& pose : collector_->trajectory.Compose().poses)
      poses.push_back(pose.map_from_camera);
    return poses;
  }

  SlamConfig config_;
  std::unique_ptr<Collector> collector_;
};

TEST_P(SemanticSessionTest, WhatMovesIsSeenButNothingIsLocatedByIt) {
  const double with_classes = Run();
  EXPECT_LT(with_classes, 0.03);
  EXPECT_GT(collector_->Count(kBuilding), 100);
  config_.semantics.filter_inactive = false;
  const double without = Run();
  EXPECT_GT(without, 2 * with_classes) << "the tailgate carries the map along";
}

TEST_P(SemanticSessionTest, SwitchedOffMasksChangeNothing) {
  config_.semantics.enabled = false;
  Run();
  const std::vector<SE3> off = Poses();
  EXPECT_EQ(collector_->Count(kUnknownClass), static_cast<int>(collector_->points.size()));
  config_.semantics.enabled = true;
  Run([](FrameInput* frame) { frame->class_mask.release(); });
  const std::vector<SE3> no_masks = Poses();
  // One class all over says nothing either.
  Run([](FrameInput* frame) { frame->class_mask = kBuilding; });
  const std::vector<SE3> one_class = Poses();
  EXPECT_EQ(collector_->Count(kBuilding), static_cast<int>(collector_->points.size()));
  ASSERT_EQ(off.size(), no_masks.size());
  ASSERT_EQ(off.size(), one_class.size());
  for (size_t i = 0; i < off.size(); ++i) {
    EXPECT_EQ(off[i].translation(), no_masks[i].translation()) << i;
    EXPECT_EQ(off[i].translation(), one_class[i].translation()) << i;
  }
}

TEST_P(SemanticSessionTest, ImprobableClassesAreNotTaken) {
  config_.semantics.min_confidence = 0.5;
  Run([](FrameInput* frame) {
    frame->class_confidence = cv::Mat(frame->class_mask.size(), CV_8UC1, cv::Scalar(127));
  });
  EXPECT_EQ(collector_->Count(kUnknownClass), static_cast<int>(collector_->points.size()));
  Run([](FrameInput* frame) {
    frame->class_confidence = cv::Mat(frame->class_mask.size(), CV_8UC1, cv::Scalar(128));
  });
  EXPECT_EQ(collector_->Count(kUnknownClass), 0);
}

TEST_P(SemanticSessionTest, CornersOnTheRimOfTheSkyAreNoSky) {
  constexpr uint8_t kSky = 13;
  // Stripes of sky, five pixels wide, everywhere.
  const auto stripes = [](FrameInput* frame) {
    frame->class_mask = kBuilding;
    for (int x = 0; x + 5 <= frame->class_mask.cols; x += 10) frame->class_mask.colRange(x, x + 5) = kSky;
  };
  config_.semantics.sky_rim_px = 4;
  Run(stripes);
  EXPECT_EQ(collector_->Count(kSky), 0);
  const int with_rim = collector_->Count(kBuilding);
  EXPECT_GT(with_rim, 100);
  config_.semantics.sky_rim_px = 0;
  Run(stripes);
  EXPECT_LT(collector_->Count(kBuilding), 0.9 * with_rim);
}

TEST_P(SemanticSessionTest, ConfidenceMustFitTheImage) {
  auto session = Session::Create(config_, SmallRig(GetParam()),
                                 (collector_ = std::make_unique<Collector>()).get(), nullptr);
  FrameInput frame = Drive().front();
  frame.class_confidence = cv::Mat(10, 10, CV_8UC1);
  const auto answer = (*session)->Track(frame);
  ASSERT_FALSE(answer.ok());
  EXPECT_NE(answer.status().message().find("class confidence is 10x10"), std::string::npos)
      << answer.status();
}

INSTANTIATE_TEST_SUITE_P(Sensors, SemanticSessionTest,
                         ::testing::Values(SensorType::kMono, SensorType::kRgbd));

}  // namespace
}  // namespace semmap
