#include "slam/pipeline/map_pruner.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "slam/pipeline/map_localizer.h"
#include "slam/pipeline/map_optimizer.h"
#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

// Half a lap with keyframes close together: most of what one sees, its neighbours see, too.
constexpr int kKeyFrames = 60;
constexpr double kStep = kRingStep / 2;

class MapPrunerTest : public ::testing::Test {
 protected:
  PruneResult Prune(const PruneBudget& budget) {
    return PruneToBudget(budget, camera_, &map_, nullptr).value();
  }

  // How many of the views between keyframes are found where they were taken.
  int CountFound() const {
    const PlaceMemory places = Remember(map_);
    const MapLocalizer localizer(RelocalizationConfig(), 1);
    int found = 0;
    for (int i = 1; i < kKeyFrames - 1; i += 3) {
      const SE3 world_from_camera = RingWorld::WorldFromCamera((i + 0.5) * kStep);
      const RingView view = world_.View(camera_, world_from_camera, static_cast<uint32_t>(5000 + i));
      const FeatureGrid grid(camera_.bounds, view.features.keypoints);
      const MapLocalization located =
          localizer.Locate(map_, places, camera_, {view.features, grid}, PlacePrior(), 0);
      if (!located.found) continue;
      const SE3 error = located.found->fix.camera_from_map * world_from_camera;
      found += error.translation().norm() < 0.2 ? 1 : 0;
    }
    return found;
  }
  static constexpr int kLooked = 20;

  RingWorld world_{1};
  MappingCamera camera_ = RingWorld::Camera(SensorType::kStereo);
  Map map_ = DriveRing(world_, camera_, kKeyFrames, kStep, {});
};

TEST_F(MapPrunerTest, KeepsTheBudgetAndPlacesAreStillFound) {
  ASSERT_EQ(CountFound(), kLooked);
  const size_t points = map_.points().size();
  const PruneResult result = Prune({20, points / 2});
  EXPECT_EQ(map_.keyframes().size(), 20U);
  EXPECT_EQ(result.removed_keyframes, 40U);
  EXPECT_LE(map_.points().size(), points / 2);
  EXPECT_EQ(result.removed_points, points - map_.points().size());
  EXPECT_NE(map_.FindKeyFrame(KeyFrameId(1)), nullptr) << "the map's frame";
  EXPECT_GE(CountFound(), kLooked - 1);
}

TEST_F(MapPrunerTest, KeyframesAreThinnedOutEvenly) {
  Prune({15, 0});
  const std::vector<KeyFrameId> left = SortedKeyFrames(map_);
  for (size_t i = 1; i < left.size(); ++i)
    EXPECT_LE(left[i].value() - left[i - 1].value(), 12U) << "a gap behind " << left[i - 1].value();
}

TEST_F(MapPrunerTest, RemovedKeyframesHaveHeirsThatAreThere) {
  map_.TakeDelta();
  Prune({10, 0});
  const MapDelta changes = map_.TakeDelta();
  ASSERT_EQ(changes.removed_keyframes.size(), 50U);
  // In their order, as a store applies them.
  std::vector<KeyFrameId> gone;
  for (const RemovedKeyFrame& removal : changes.removed_keyframes) {
    EXPECT_EQ(std::count(gone.begin(), gone.end(), removal.heir), 0) << removal.removed.value();
    gone.push_back(removal.removed);
  }
  for (const MapPointRecord& point : changes.upserted_points)
    EXPECT_NE(map_.FindKeyFrame(point.reference_keyframe), nullptr);
}

TEST_F(MapPrunerTest, WeakPointsGoFirst) {
  const auto mean_observations = [&] {
    double sum = 0;
    for (const auto& [id, point] : map_.points()) sum += static_cast<double>(point.observations.size());
    return sum / static_cast<double>(map_.points().size());
  };
  const double before = mean_observations();
  Prune({0, map_.points().size() * 2 / 3});
  EXPECT_EQ(map_.keyframes().size(), static_cast<size_t>(kKeyFrames));
  EXPECT_GT(mean_observations(), 1.1 * before);
}

TEST_F(MapPrunerTest, ABudgetThatIsKeptChangesNothing) {
  map_.TakeDelta();
  const PruneResult result = Prune({kKeyFrames, map_.points().size()});
  EXPECT_EQ(result.removed_keyframes + result.removed_points, 0U);
  EXPECT_TRUE(map_.TakeDelta().empty());
}

TEST_F(MapPrunerTest, CanBeCancelled) {
  const auto result = PruneToBudget({10, 0}, camera_, &map_, [](double) { return false; });
  EXPECT_TRUE(absl::IsCancelled(result.status()));
}

class MapOptimizerTest : public MapPrunerTest {};

TEST_F(MapOptimizerTest, PerturbedKeyframesGoBack) {
  OptimizeWholeMap(40, camera_, nullptr, &map_);
  const double before = RingError(map_, kStep, false);
  for (const KeyFrameId id : SortedKeyFrames(map_)) {
    if (id.value() == 1) continue;
    const double sign = id.value() % 2 == 0 ? 1 : -1;
    const SE3 push(ExpSO3({0, 0.004 * sign, 0}), {0.03 * sign, 0, 0.03});
    map_.SetPose(id, push * map_.FindKeyFrame(id)->camera_from_map);
  }
  const double perturbed = RingError(map_, kStep, false);
  ASSERT_GT(perturbed, 1.5 * before);
  const OptimizeResult result = OptimizeWholeMap(40, camera_, nullptr, &map_);
  EXPECT_FALSE(result.stopped);
  EXPECT_LE(result.iterations, 40);
  EXPECT_LT(result.final_rms_px, 0.5 * result.initial_rms_px);
  EXPECT_LT(RingError(map_, kStep, false), before + 0.2 * (perturbed - before));
}

TEST_F(MapOptimizerTest, StoppedItLeavesTheMapAsItWas) {
  map_.TakeDelta();
  const std::atomic<bool> stop = true;
  const OptimizeResult result = OptimizeWholeMap(40, camera_, &stop, &map_);
  EXPECT_TRUE(result.stopped);
  EXPECT_TRUE(map_.TakeDelta().empty());
}

}  // namespace
}  // namespace semmap
