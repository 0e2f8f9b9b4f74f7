#include "slam/pipeline/relocalizer.h"

#include <gtest/gtest.h>

#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

class RelocalizerTest : public ::testing::TestWithParam<SensorType> {
 protected:
  RelocalizerTest()
      : world_(1),
        camera_(RingWorld::Camera(GetParam())),
        map_(DriveRing(world_, camera_, 40, kRingStep, {})),
        places_(Remember(map_)) {}

  Relocalization Find(const RingView& view) const {
    const FeatureGrid grid(camera_.bounds, view.features.keypoints);
    return Relocalizer(RelocalizationConfig(), 1)
        .Relocalize(map_, places_, camera_, {view.features, grid}, 7);
  }

  RingWorld world_;
  MappingCamera camera_;
  Map map_;
  PlaceMemory places_;
};

TEST_P(RelocalizerTest, FindsACameraBesideTheDrive) {
  for (int i = 0; i < 20; ++i) {
    const double angle = (3 + 1.7 * i) * kRingStep;
    const SE3 aside(ExpSO3({0.01, 0.05, 0}), {0.4, 0.1, 0.2});
    const SE3 world_from_camera = RingWorld::WorldFromCamera(angle) * aside;
    const Relocalization found =
        Find(world_.View(camera_, world_from_camera, static_cast<uint32_t>(100 + i)));
    ASSERT_TRUE(found.fix.has_value()) << i << ", failure " << static_cast<int>(found.failure);
    const SE3 error = found.fix->camera_from_map * world_from_camera;  // the map's frame is the world's
    EXPECT_LT(error.translation().norm(), 0.03) << i;
    EXPECT_LT(error.RotationAngle(), 0.005) << i;
    EXPECT_EQ(found.failure, LocalizationFailure::kNone);
    EXPECT_EQ(found.view->version, 7);
    EXPECT_GT(found.fix->covariance.trace(), 0);
    // Points are those of the corners that the keypoints show: their projections agree.
    EXPECT_GE(found.fix->agreement.inliers, 50);
  }
}

TEST_P(RelocalizerTest, AnotherPlaceIsNotFoundAndTheReasonKept) {
  const RingWorld elsewhere(2);
  for (int i = 0; i < 10; ++i) {
    const auto view = elsewhere.View(camera_, RingWorld::WorldFromCamera(i * 0.5), static_cast<uint32_t>(i));
    const Relocalization found = Find(view);
    EXPECT_FALSE(found.fix.has_value());
    EXPECT_EQ(found.failure, LocalizationFailure::kTooFewMatches);
    EXPECT_GT(found.candidates, 0);
  }
}

TEST_P(RelocalizerTest, AnEmptyImageHasNoCandidates) {
  const Relocalization found = Find(RingView());
  EXPECT_FALSE(found.fix.has_value());
  EXPECT_EQ(found.failure, LocalizationFailure::kNoCandidates);
}

INSTANTIATE_TEST_SUITE_P(Sensors, RelocalizerTest, ::testing::Values(SensorType::kMono, SensorType::kStereo));

}  // namespace
}  // namespace semmap
