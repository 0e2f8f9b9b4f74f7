#include "slam/evaluation/trajectory_collector.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

SE3 At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

KeyFrameRecord KeyFrameAt(uint64_t id, double x) {
  KeyFrameRecord keyframe;
  keyframe.id = KeyFrameId(id);
  keyframe.map_from_camera = At(x);
  return keyframe;
}

FramePose FrameOn(uint64_t sequence, uint64_t keyframe, double x) {
  return {sequence, static_cast<TimestampNs>(sequence) * 100, KeyFrameId(keyframe), At(x)};
}

std::vector<double> Positions(const TrajectoryCollector& collector) {
  std::vector<double> positions;
  for (const StampedPose& pose : collector.Compose().poses)
    positions.push_back(pose.map_from_camera.translation().x());
  return positions;
}

MapDelta TwoKeyFrames() {
  MapDelta delta;
  delta.added_keyframes = {KeyFrameAt(1, 0), KeyFrameAt(2, 10)};
  delta.frames = {FrameOn(0, 1, 0), FrameOn(1, 1, 4), FrameOn(2, 2, 1)};
  return delta;
}

TEST(TrajectoryCollector, FramesFollowTheirKeyFrame) {
  TrajectoryCollector collector;
  collector.OnDelta(TwoKeyFrames());
  EXPECT_EQ(Positions(collector), (std::vector<double>{0, 4, 11}));
  MapDelta moved;
  moved.moved_keyframes = {{KeyFrameId(2), At(20), KeyFrameId(1)}};
  collector.OnDelta(moved);
  EXPECT_EQ(Positions(collector), (std::vector<double>{0, 4, 21}));
  EXPECT_EQ(collector.Compose().poses[2].timestamp, 200);
}

TEST(TrajectoryCollector, DistancesGrowWithTheUnitOfTheKeyFrame) {
  TrajectoryCollector collector;
  collector.OnDelta(TwoKeyFrames());
  MapDelta loop;
  loop.moved_keyframes = {{KeyFrameId(2), At(20), KeyFrameId(1), 2.0}};
  loop.frames = {FrameOn(3, 2, 3)};  // measured in the new unit already
  collector.OnDelta(loop);
  EXPECT_EQ(Positions(collector), (std::vector<double>{0, 4, 22, 23}));
}

TEST(TrajectoryCollector, FramesOfACulledKeyFrameMoveToTheHeirAndItsHeir) {
  TrajectoryCollector collector;
  collector.OnDelta(TwoKeyFrames());
  MapDelta first;
  first.added_keyframes = {KeyFrameAt(3, 100)};
  first.removed_keyframes = {{KeyFrameId(2), KeyFrameId(3), At(-90)}};
  collector.OnDelta(first);
  EXPECT_EQ(Positions(collector), (std::vector<double>{0, 4, 11}));
  MapDelta second;
  second.removed_keyframes = {{KeyFrameId(3), KeyFrameId(1), At(50)}};
  // A frame that was tracked against the keyframe before it was culled may arrive later.
  second.frames = {FrameOn(3, 2, 2)};
  collector.OnDelta(second);
  EXPECT_EQ(Positions(collector), (std::vector<double>{0, 4, -39, -38}));
}

TEST(TrajectoryCollector, AResetForgetsEverythingBefore) {
  TrajectoryCollector collector;
  collector.OnDelta(TwoKeyFrames());
  MapDelta reset;
  reset.reset = true;
  reset.added_keyframes = {KeyFrameAt(9, 7)};
  reset.frames = {FrameOn(5, 9, 1)};
  collector.OnDelta(reset);
  EXPECT_EQ(Positions(collector), (std::vector<double>{8}));
  EXPECT_EQ(collector.Sequences(), (std::vector<uint64_t>{5}));
}

TEST(TrajectoryCollector, LeavesOutFramesOfUnknownKeyFrames) {
  TrajectoryCollector collector;
  MapDelta delta = TwoKeyFrames();
  delta.frames.push_back(FrameOn(3, 77, 1));
  delta.removed_keyframes = {{KeyFrameId(1), KeyFrameId(1), At(1)}};  // its own heir: must not hang
  collector.OnDelta(delta);
  EXPECT_EQ(Positions(collector), (std::vector<double>{11}));
}

}  // namespace
}  // namespace semmap
