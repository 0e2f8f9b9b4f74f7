#include "slam/pipeline/map_localizer.h"

#include <gtest/gtest.h>

#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

class MapLocalizerTest : public ::testing::TestWithParam<SensorType> {
 protected:
  MapLocalizerTest() : world_(1), camera_(RingWorld::Camera(GetParam())) { Drive(40, {}); }

  void Drive(int keyframes, const RingDrift& drift) {
    map_.emplace(DriveRing(world_, camera_, keyframes, kRingStep, drift));
    places_.emplace(Remember(*map_));
  }

  MapLocalization Find(const RingView& view, const PlacePrior& prior = {}) const {
    const FeatureGrid grid(camera_.bounds, view.features.keypoints);
    return MapLocalizer(RelocalizationConfig(), 1)
        .Locate(*map_, *places_, camera_, {view.features, grid}, prior, 7);
  }
  RingView ViewAt(double steps, uint32_t seed) const {
    return world_.View(camera_, RingWorld::WorldFromCamera(steps * kRingStep), seed);
  }

  RingWorld world_;
  MappingCamera camera_;
  std::optional<Map> map_;
  std::optional<PlaceMemory> places_;
};

TEST_P(MapLocalizerTest, FindsACameraBesideTheDrive) {
  for (int i = 0; i < 20; ++i) {
    const double angle = (3 + 1.7 * i) * kRingStep;
    const SE3 aside(ExpSO3({0.01, 0.05, 0}), {0.4, 0.1, 0.2});
    const SE3 world_from_camera = RingWorld::WorldFromCamera(angle) * aside;
    const RingView view = world_.View(camera_, world_from_camera, static_cast<uint32_t>(100 + i));
    const MapLocalization located = Find(view);
    ASSERT_TRUE(located.found.has_value()) << i << ", failure " << static_cast<int>(located.failure);
    const SE3 error =
        located.found->fix.camera_from_map * world_from_camera;  // the map's frame is the world's
    EXPECT_LT(error.translation().norm(), 0.03) << i;
    EXPECT_LT(error.RotationAngle(), 0.005) << i;
    EXPECT_EQ(located.failure, LocalizationFailure::kNone);
    EXPECT_EQ(located.agreement.inliers, located.found->fix.agreement.inliers);
    EXPECT_GE(located.matches, 15);
    EXPECT_EQ(located.found->view->version, 7U);
    // The keyframe that sees most stands where the camera is.
    const auto seeing = KeyFramesSeeing(MapInMemory(*map_, *places_, 7), *located.found, 3);
    ASSERT_EQ(seeing.size(), 3U);
    EXPECT_LT((map_->FindKeyFrame(seeing.front())->Center() - world_from_camera.translation()).norm(), 4);
  }
}

TEST_P(MapLocalizerTest, AnotherPlaceIsNotFound) {
  const RingWorld elsewhere(2);
  for (int i = 0; i < 10; ++i) {
    const MapLocalization located =
        Find(elsewhere.View(camera_, RingWorld::WorldFromCamera(i * 0.5), static_cast<uint32_t>(i)));
    EXPECT_FALSE(located.found.has_value());
    EXPECT_NE(located.failure, LocalizationFailure::kNone);
  }
}

TEST_P(MapLocalizerTest, AnEmptyImageHasNoCandidates) {
  const MapLocalization located = Find(RingView());
  EXPECT_FALSE(located.found.has_value());
  EXPECT_EQ(located.failure, LocalizationFailure::kNoCandidates);
}

// A lap and a bit with an open end: the start is in the map twice, far apart. Who stands there cannot know
// which of both it is, and must not be told one of them.
TEST_P(MapLocalizerTest, APlaceThatIsThereTwiceIsAmbiguous) {
  Drive(kRingKeyFrames + 4, {.turn = 0.01});
  const MapLocalization twice = Find(ViewAt(2.4, 100));
  EXPECT_FALSE(twice.found.has_value());
  EXPECT_EQ(twice.failure, LocalizationFailure::kDegeneratePose);
  EXPECT_GT(twice.rival_inliers, 50);
  const MapLocalization once = Find(ViewAt(24.4, 101));
  EXPECT_TRUE(once.found.has_value());
  EXPECT_EQ(once.rival_inliers, 0);
}

TEST_P(MapLocalizerTest, APriorSaysWhichOfTwo) {
  Drive(kRingKeyFrames + 4, {.turn = 0.01});
  PlacePrior prior;
  prior.position = {map_->FindKeyFrame(KeyFrameId(3))->Center(), 3.0};
  const MapLocalization located = Find(ViewAt(2.4, 100), prior);
  ASSERT_TRUE(located.found.has_value()) << static_cast<int>(located.failure);
  EXPECT_TRUE(prior.Admits(located.found->fix.camera_from_map.Inverse()));
}

TEST_P(MapLocalizerTest, APriorThatIsNotSoLeavesNothing) {
  const RingView view = ViewAt(10.3, 100);
  ASSERT_TRUE(Find(view).found.has_value());
  const SE3 truth = RingWorld::WorldFromCamera(10.3 * kRingStep);
  PlacePrior far;
  far.position = {map_->FindKeyFrame(KeyFrameId(30))->Center(), 5.0};
  EXPECT_FALSE(Find(view, far).found.has_value());
  PlacePrior backwards;
  backwards.heading = {-(truth.rotation() * Eigen::Vector3d::UnitZ()), 0.3};
  EXPECT_FALSE(Find(view, backwards).found.has_value());
  PlacePrior forwards;
  forwards.heading = {truth.rotation() * Eigen::Vector3d::UnitZ(), 0.3};
  EXPECT_TRUE(Find(view, forwards).found.has_value());
}

INSTANTIATE_TEST_SUITE_P(Sensors, MapLocalizerTest,
                         ::testing::Values(SensorType::kMono, SensorType::kStereo));

FrameFeatures FeaturesOfClasses(const std::vector<uint8_t>& classes) {
  FrameFeatures features;
  for (const uint8_t semantic_class : classes) {
    Keypoint keypoint;
    keypoint.semantic_class = semantic_class;
    features.keypoints.push_back(keypoint);
  }
  features.descriptors.resize(classes.size());
  return features;
}

TEST(ClassAgreementTest, CountsPairsWithClassesOnBothSides) {
  auto view = std::make_shared<LocalMapView>();
  for (const uint8_t semantic_class : std::vector<uint8_t>{10, 7, 255}) {
    ViewPoint point;
    point.id = MapPointId(view->size() + 1);
    point.semantic_class = semantic_class;
    view->Add(point);
  }
  MapFix fix{view, {}};
  fix.fix.matches = {0, 1, 2, -1, 0};
  // 10 agrees, 1 does not, of the third point nothing is known, the fourth keypoint sees nothing, the fifth
  // has no class.
  EXPECT_EQ(ClassAgreement(fix, FeaturesOfClasses({10, 1, 5, 10, 255})), 0.5);
  EXPECT_EQ(ClassAgreement(fix, FeaturesOfClasses({10, 7, 5, 10, 255})), 1.0);
  EXPECT_FALSE(ClassAgreement(fix, FeaturesOfClasses({255, 255, 5, 10, 255})).has_value());
}

TEST(PlacePriorTest, AdmitsWhatItSays) {
  const SE3 camera(Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY())), {1, 2, 3});
  PlacePrior prior;
  EXPECT_TRUE(prior.Admits(camera));
  prior.position = {{1, 2, 4}, 1.01};
  EXPECT_TRUE(prior.Admits(camera));
  prior.position->radius = 0.99;
  EXPECT_FALSE(prior.Admits(camera));
  prior.position.reset();
  prior.heading = {Eigen::Vector3d::UnitZ(), 0.51};
  EXPECT_TRUE(prior.Admits(camera));
  prior.heading->tolerance = 0.49;
  EXPECT_FALSE(prior.Admits(camera));
}

}  // namespace
}  // namespace semmap
