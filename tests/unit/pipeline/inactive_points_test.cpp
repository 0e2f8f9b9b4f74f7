// Points of inactive classes in the steps of the mapper: they take no part, are remembered, and may come
// back.
#include <gtest/gtest.h>

#include "slam/pipeline/keyframe_matcher.h"
#include "slam/pipeline/local_bundle.h"
#include "slam/pipeline/point_fusion.h"
#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

constexpr uint8_t kBuilding = 1;
constexpr uint8_t kVehicles = 10;
constexpr uint64_t kKeyFrames = 6;
constexpr double kStep = 0.04;  // radians

bool IsVehicle(int world_point) { return world_point % 4 == 0; }

class InactivePointsTest : public ::testing::Test {
 protected:
  InactivePointsTest()
      : world_(1),
        camera_(RingWorld::Camera(SensorType::kStereo)),
        map_(RingWorld::ScaleInfo(), PointClassPolicy{true, ClassSet(kInactiveClasses)}) {
    std::unordered_map<int, MapPointId> known;
    for (uint64_t id = 1; id <= kKeyFrames; ++id) {
      const RingView view = AddKeyFrame(id, kVehicles);
      for (uint32_t k = 0; k < view.world_points.size(); ++k) {
        MapPointId& point = known[view.world_points[k]];
        if (!point.IsValid()) point = map_.AddPoint(world_.corner(view.world_points[k]), KeyFrameId(id));
        map_.AddObservation(point, KeyFrameId(id), k);
      }
      map_.ChooseParent(KeyFrameId(id));
    }
    for (const auto& [corner, point] : known) {
      map_.UpdateAppearance(point);
      (IsVehicle(corner) ? vehicles_ : buildings_).push_back(point);
    }
  }

  // What is a vehicle is seen as `vehicle_class`.
  RingView Look(uint64_t id, uint8_t vehicle_class) const {
    RingView view = world_.View(camera_, RingWorld::WorldFromCamera(static_cast<double>(id) * kStep),
                                static_cast<uint32_t>(id));
    for (size_t k = 0; k < view.world_points.size(); ++k)
      view.features.keypoints[k].semantic_class = IsVehicle(view.world_points[k]) ? vehicle_class : kBuilding;
    return view;
  }
  RingView AddKeyFrame(uint64_t id, uint8_t vehicle_class) {
    RingView view = Look(id, vehicle_class);
    const SE3 world_from_camera = RingWorld::WorldFromCamera(static_cast<double>(id) * kStep);
    map_.AddKeyFrame(testing::MakeKeyFrame(camera_, KeyFrameId(id), view, world_from_camera.Inverse()));
    return view;
  }

  RingWorld world_;
  MappingCamera camera_;
  Map map_;
  std::vector<MapPointId> vehicles_;
  std::vector<MapPointId> buildings_;
};

TEST_F(InactivePointsTest, AreNotAmongThePointsThatAreFusedOrMatched) {
  const auto seen = PointsSeenBy(map_, {KeyFrameId(2), KeyFrameId(3)});
  EXPECT_GT(seen.size(), 100U);
  for (const MapPointId id : seen) EXPECT_EQ(map_.FindPoint(id)->semantic_class, kBuilding);
  const RingView view = Look(20, kVehicles);
  const auto pairs = MatchExhaustively(AssociationRule(SemanticsConfig()), map_,
                                       *map_.FindKeyFrame(KeyFrameId(6)), view.features);
  EXPECT_GT(pairs.size(), 50U);
  for (const KeypointPair& pair : pairs) EXPECT_FALSE(IsVehicle(view.world_points[pair.second]));
}

TEST_F(InactivePointsTest, TieNoKeyFramesTogether) {
  const auto& keyframe = *map_.FindKeyFrame(KeyFrameId(2));
  const int shared = keyframe.covisible.at(KeyFrameId(3));
  int buildings = 0;
  for (const MapPointId id : keyframe.points) {
    const MapPoint* point = map_.FindActivePoint(id);
    if (point == nullptr) continue;
    for (const Observation& observation : point->observations)
      buildings += observation.keyframe == KeyFrameId(3) ? 1 : 0;
  }
  EXPECT_EQ(shared, buildings);
}

TEST_F(InactivePointsTest, RideAlongWhenTheirKeyFrameIsAdjusted) {
  const KeyFrameId last(kKeyFrames);
  const SE3 truth = map_.FindKeyFrame(last)->camera_from_map;
  for (uint64_t id = 2; id <= kKeyFrames; ++id) {
    const KeyFrameId moved(id);
    map_.SetPose(moved, SE3(Eigen::Quaterniond::Identity(), {0.05, 0, 0.02}) *
                            map_.FindKeyFrame(moved)->camera_from_map);
  }
  const auto in_reference = [&](MapPointId id) -> Eigen::Vector3d {
    const MapPoint& point = *map_.FindPoint(id);
    return map_.FindKeyFrame(point.reference_keyframe)->camera_from_map * point.position_in_map;
  };
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> passengers;
  for (const MapPointId id : vehicles_) {
    if (map_.FindPoint(id)->reference_keyframe != KeyFrameId(1))
      passengers.emplace_back(id, in_reference(id));
  }
  ASSERT_GT(passengers.size(), 0U);
  AdjustLocalMap(MappingConfig(), camera_.model, last, nullptr, &map_);
  const SE3 after = map_.FindKeyFrame(last)->camera_from_map;
  EXPECT_LT((after * truth.Inverse()).translation().norm(), 0.01) << "buildings put it back";
  for (const auto& [id, before] : passengers) EXPECT_NEAR((in_reference(id) - before).norm(), 0, 1e-9);
}

TEST_F(InactivePointsTest, AreObservedAndStayWhatTheyAre) {
  AddKeyFrame(7, kVehicles);
  const int observed = ObserveInactivePoints(camera_, KeyFrameId(7), {KeyFrameId(5), KeyFrameId(6)}, &map_);
  EXPECT_GT(observed, 20);
  int seeing = 0;
  for (const MapPointId id : map_.FindKeyFrame(KeyFrameId(7))->points) {
    if (!id.IsValid()) continue;
    ++seeing;
    EXPECT_FALSE(map_.FindPoint(id)->active);
  }
  EXPECT_EQ(seeing, observed);
  // A keypoint that shows an inactive point is not there for others.
  FusePoints(camera_, buildings_, KeyFrameId(7), FusionTolerance(), &map_);
  for (const MapPointId id : vehicles_) EXPECT_NE(map_.FindPoint(id), nullptr);
}

TEST_F(InactivePointsTest, ComeBackWhenTheVotesTurn) {
  const auto active_vehicles = [&] {
    return std::count_if(vehicles_.begin(), vehicles_.end(),
                         [&](MapPointId id) { return map_.FindActivePoint(id) != nullptr; });
  };
  EXPECT_EQ(active_vehicles(), 0);
  for (uint64_t id = 7; id <= 7 + 2 * kKeyFrames; ++id) {
    AddKeyFrame(id, kBuilding);
    ObserveInactivePoints(camera_, KeyFrameId(id),
                          {KeyFrameId(id - 1), KeyFrameId(id - 2), KeyFrameId(id - 3)}, &map_);
  }
  EXPECT_GT(active_vehicles(), 10);
}

TEST_F(InactivePointsTest, DoNotDescribeAPlace) {
  const auto vocabulary = RandomVocabulary(12, 5);
  const PlaceMemory places(vocabulary, PlaceQueryLimits(), ClassSet(kInactiveClasses));
  const FrameFeatures features = Look(3, kVehicles).features;
  FrameFeatures buildings;
  for (size_t i = 0; i < features.size(); ++i) {
    if (features.keypoints[i].semantic_class == kVehicles) continue;
    buildings.keypoints.push_back(features.keypoints[i]);
    buildings.descriptors.push_back(features.descriptors[i]);
  }
  ASSERT_LT(buildings.size(), features.size());
  const PlaceDescription description = places.Describe(features);
  EXPECT_EQ(description.words, places.Describe(buildings).words);
  EXPECT_EQ(description.nodes.keypoints.size(), buildings.size());
  for (const uint32_t keypoint : description.nodes.keypoints)
    EXPECT_EQ(features.keypoints.at(keypoint).semantic_class, kBuilding);
}

}  // namespace
}  // namespace semmap
