// Two drives over overlapping stretches of a ring road, mapped in frames and units of their own, become one
// map.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "slam/geometry/alignment.h"
#include "slam/pipeline/map_joiner.h"
#include "slam/pipeline/map_overlap.h"
#include "tests/support/side_by_side.h"
#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

// The target's keyframes stand at steps 0 to 23, the source's at 14 to 37: a quarter of the ring is in both.
constexpr int kKeyFrames = 24;
constexpr int kFirstOfSource = 14;
// Units of a source without depth for one of the target.
constexpr double kSourceUnit = 2.5;
constexpr KeyFrameId kLastOfTarget{kSecondKeyFrames};

class MapMergeTest : public ::testing::TestWithParam<SensorType> {
 protected:
  MapMergeTest() : camera_(RingWorld::Camera(GetParam())), map_(TwoDrives(kFirstOfSource)) {}

  bool mono() const { return GetParam() == SensorType::kMono; }
  double source_unit() const { return mono() ? kSourceUnit : 1.0; }
  RingDrift drift() const { return mono() ? RingDrift{0.0005, 0.001} : RingDrift{0.001, 0}; }

  Map TwoDrives(int first_of_source) const {
    return SideBySide(
        RingWorld::ScaleInfo(), camera_.bounds, DriveRing(world_, camera_, kKeyFrames, kRingStep, drift()),
        DriveRing(world_, camera_, kKeyFrames, kRingStep, drift(), first_of_source, source_unit()));
  }

  MapOverlap Overlap() const {
    return FindOverlap(config_, camera_, Remember(map_), map_, kLastOfTarget, nullptr).value();
  }
  MapJoiner Joiner(const MapOverlap& overlap) {
    return {config_, camera_, overlap, kLastOfTarget, mono(), &map_};
  }

  // Where the ring's angle is that the keyframe stands at.
  static double AngleOf(KeyFrameId id) {
    const uint64_t step =
        id <= kLastOfTarget ? id.value() - 1 : id.value() - kSecondKeyFrames - 1 + kFirstOfSource;
    return static_cast<double>(step) * kRingStep;
  }

  // Root mean square distance of all keyframes from the truth, after one alignment.
  double Error() const {
    std::vector<Eigen::Vector3d> truth;
    std::vector<Eigen::Vector3d> estimate;
    for (const auto& [id, keyframe] : map_.keyframes()) {
      truth.push_back(RingWorld::WorldFromCamera(AngleOf(id)).translation());
      estimate.push_back(keyframe.Center());
    }
    const Sim3 truth_from_map = AlignPoints(estimate, truth, mono()).value();
    double squared = 0;
    for (size_t i = 0; i < truth.size(); ++i)
      squared += (truth_from_map * estimate[i] - truth[i]).squaredNorm();
    return std::sqrt(squared / static_cast<double>(truth.size()));
  }

  SlamConfig config_;
  RingWorld world_{1};
  MappingCamera camera_;
  Map map_;
};

TEST_P(MapMergeTest, OverlapTellsTheTrueSimilarity) {
  const MapOverlap overlap = Overlap();
  ASSERT_TRUE(overlap.IsSound(config_.merge));
  EXPECT_EQ(overlap.keyframes, kKeyFrames);
  EXPECT_GE(overlap.links.size(), 8U);
  EXPECT_EQ(overlap.rivals, 0);
  // The source's first keyframe, its frame, stands where the target's fifteenth does.
  const SE3 truth = RingWorld::WorldFromCamera(kFirstOfSource * kRingStep);
  const Sim3& found = overlap.target_from_source;
  EXPECT_NEAR(found.scale, 1 / source_unit(), mono() ? 0.03 / source_unit() : 1e-12);
  EXPECT_LT((found.rigid.translation() - truth.translation()).norm(), 0.4);
  EXPECT_LT(found.rigid.rotation().angularDistance(truth.rotation()), 0.03);
  for (const Loop& link : overlap.links) {
    EXPECT_LE(link.old, kLastOfTarget);
    EXPECT_GT(link.current, kLastOfTarget);
    EXPECT_LT(std::abs(AngleOf(link.old) - AngleOf(link.current)), 8 * kRingStep);
  }
}

TEST_P(MapMergeTest, JoinedMapIsOne) {
  const MapOverlap overlap = Overlap();
  ASSERT_TRUE(overlap.IsSound(config_.merge));
  const size_t points_before = map_.points().size();
  MapJoiner joiner = Joiner(overlap);
  joiner.Align(nullptr);
  const int fused = joiner.Fuse(nullptr);
  EXPECT_GT(fused, 300);
  EXPECT_EQ(map_.points().size(), points_before - static_cast<size_t>(fused));
  const double error_before = joiner.MeasureSeam().rms_px;
  const size_t seam = joiner.MeasureSeam().observations;
  EXPECT_GT(seam, 1000U);
  joiner.Adjust(nullptr);
  EXPECT_LT(joiner.MeasureSeam().rms_px, error_before);
  EXPECT_LT(joiner.MeasureSeam().rms_px, 1.0);
  EXPECT_LT(Error(), 0.25);
  // The target's frame stays.
  EXPECT_LT(map_.FindKeyFrame(KeyFrameId(1))->Center().norm(), 1e-12);
  // Both sides see the same, and one tree holds all.
  bool covisible = false;
  for (const auto& [id, shared] : map_.FindKeyFrame(overlap.links.front().current)->covisible)
    covisible = covisible || id <= kLastOfTarget;
  EXPECT_TRUE(covisible);
  for (const auto& [id, keyframe] : map_.keyframes()) {
    KeyFrameId ancestor = id;
    std::set<KeyFrameId> passed;
    while (map_.FindKeyFrame(ancestor)->parent.IsValid()) {
      ASSERT_TRUE(passed.insert(ancestor).second) << "a cycle at " << ancestor.value();
      ancestor = map_.FindKeyFrame(ancestor)->parent;
    }
    EXPECT_EQ(ancestor, KeyFrameId(1));
  }
}

TEST_P(MapMergeTest, ChangesTellHowTheSourceWasScaled) {
  const MapOverlap overlap = Overlap();
  MapJoiner joiner = Joiner(overlap);
  joiner.Align(nullptr);
  const MapDelta changes = map_.TakeDelta();
  ASSERT_EQ(changes.moved_keyframes.size(), map_.keyframes().size());
  EXPECT_EQ(changes.upserted_points.size(), map_.points().size());
  EXPECT_TRUE(changes.added_keyframes.empty());
  for (const KeyFramePose& moved : changes.moved_keyframes) {
    const double expected = moved.id <= kLastOfTarget ? 1.0 : 1 / source_unit();
    EXPECT_NEAR(moved.rescale, expected, mono() ? 0.05 * expected : 1e-12) << moved.id.value();
  }
}

TEST_P(MapMergeTest, MapsOfDifferentPlacesDoNotOverlap) {
  // The walls of steps 30 on cannot be seen from steps 0 to 17.
  map_ =
      SideBySide(RingWorld::ScaleInfo(), camera_.bounds, DriveRing(world_, camera_, 10, kRingStep, drift()),
                 DriveRing(world_, camera_, 10, kRingStep, drift(), 24, source_unit()));
  const MapOverlap overlap = Overlap();
  EXPECT_FALSE(overlap.IsSound(config_.merge));
  EXPECT_EQ(overlap.keyframes, 10);
  EXPECT_EQ(overlap.found, 0);
}

TEST_P(MapMergeTest, AFewKeyframesAreNotEnough) {
  config_.merge.min_keyframes = 100;
  const MapOverlap overlap = Overlap();
  EXPECT_GT(overlap.links.size(), 3U);
  EXPECT_FALSE(overlap.IsSound(config_.merge));
}

TEST_P(MapMergeTest, RivalsMakeAnOverlapUnsure) {
  MapOverlap overlap = Overlap();
  ASSERT_TRUE(overlap.IsSound(config_.merge));
  overlap.rivals = static_cast<int>(overlap.links.size());
  EXPECT_FALSE(overlap.IsSound(config_.merge));
  overlap.rivals = 0;
  for (Loop& link : overlap.links) link.old = KeyFrameId(20);
  EXPECT_FALSE(overlap.IsSound(config_.merge)) << "one place that everything looks like";
}

TEST_P(MapMergeTest, SearchCanBeCancelled) {
  int visits = 0;
  const auto visit = [&](double share) {
    EXPECT_LE(share, 1);
    return ++visits < 3;
  };
  const auto overlap = FindOverlap(config_, camera_, Remember(map_), map_, kLastOfTarget, visit);
  EXPECT_TRUE(absl::IsCancelled(overlap.status()));
  EXPECT_EQ(visits, 3);
}

INSTANTIATE_TEST_SUITE_P(Sensors, MapMergeTest, ::testing::Values(SensorType::kMono, SensorType::kStereo));

}  // namespace
}  // namespace semmap
