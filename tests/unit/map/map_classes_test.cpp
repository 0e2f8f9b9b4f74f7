// Votes, classes and activity of map points.
#include <gtest/gtest.h>

#include "slam/map/local_map_view.h"
#include "slam/map/map.h"
#include "slam/map/map_restorer.h"

namespace semmap {
namespace {

constexpr uint8_t kBuilding = 1;
constexpr uint8_t kVehicles = 10;
constexpr uint32_t kKeypoints = 8;
constexpr ImageBounds kBounds{0, 0, 400, 100};

// The first half of the keypoints lies on `left`, the other half on `right`.
KeyFrame MakeKeyFrame(uint64_t id, uint8_t left, uint8_t right) {
  auto features = std::make_shared<FrameFeatures>();
  features->keypoints.resize(kKeypoints);
  features->descriptors.resize(kKeypoints);
  for (uint32_t i = 0; i < kKeypoints; ++i)
    features->keypoints[i].semantic_class = i < kKeypoints / 2 ? left : right;
  KeyFrame keyframe;
  keyframe.id = KeyFrameId(id);
  keyframe.camera_from_map = SE3(Eigen::Quaterniond::Identity(), {0, 0, -static_cast<double>(id)});
  keyframe.features = features;
  keyframe.grid = std::make_shared<FeatureGrid>(kBounds, features->keypoints);
  keyframe.points.assign(kKeypoints, MapPointId());
  return keyframe;
}

class MapClassesTest : public ::testing::Test {
 protected:
  MapClassesTest() : map_(ScalePyramidInfo(8, 1.2), PointClassPolicy{true, ClassSet(kInactiveClasses)}) {
    for (uint64_t id = 1; id <= 5; ++id) {
      map_.AddKeyFrame(MakeKeyFrame(id, kBuilding, kVehicles));
      map_.ChooseParent(KeyFrameId(id));
    }
  }

  // Seen as a building where the keypoint is below kKeypoints / 2, else as a vehicle.
  void See(MapPointId point, uint64_t keyframe, uint32_t keypoint) {
    ASSERT_TRUE(map_.AddObservation(point, KeyFrameId(keyframe), keypoint));
  }
  MapPointId AddPoint() { return map_.AddPoint({0, 0, 20}, KeyFrameId(1)); }
  const MapPoint& At(MapPointId id) const { return *map_.FindPoint(id); }

  int Shared(uint64_t a, uint64_t b) const {
    const auto& covisible = map_.FindKeyFrame(KeyFrameId(a))->covisible;
    const auto found = covisible.find(KeyFrameId(b));
    return found == covisible.end() ? 0 : found->second;
  }

  Map map_;
};

TEST_F(MapClassesTest, ClassFollowsTheVotesAndPutsThePointAside) {
  const MapPointId id = AddPoint();
  EXPECT_TRUE(At(id).active) << "nobody said what it is";
  See(id, 1, 0);
  See(id, 2, 0);
  EXPECT_EQ(At(id).semantic_class, kBuilding);
  EXPECT_EQ(map_.FindActivePoint(id), &At(id));
  EXPECT_EQ(Shared(1, 2), 1);
  See(id, 3, 4);
  See(id, 4, 4);
  EXPECT_EQ(At(id).semantic_class, kBuilding) << "two votes each: the first stays";
  EXPECT_EQ(Shared(3, 4), 1);
  See(id, 5, 4);
  EXPECT_EQ(At(id).semantic_class, kVehicles);
  EXPECT_EQ(map_.FindActivePoint(id), nullptr);
  for (uint64_t a = 1; a <= 5; ++a) {
    for (uint64_t b = 1; b <= 5; ++b) EXPECT_EQ(Shared(a, b), 0) << a << " " << b;
  }
}

TEST_F(MapClassesTest, WrongObservationsTakeTheirVoteWithThemAndThePointComesBack) {
  const MapPointId id = AddPoint();
  See(id, 1, 4);
  See(id, 2, 4);
  See(id, 3, 0);
  See(id, 4, 0);
  EXPECT_FALSE(At(id).active);
  EXPECT_EQ(Shared(3, 4), 0);
  map_.RemoveObservation(id, KeyFrameId(1));
  EXPECT_EQ(At(id).semantic_class, kBuilding);
  EXPECT_TRUE(At(id).active);
  EXPECT_EQ(Shared(3, 4), 1);
  EXPECT_EQ(Shared(2, 4), 1);
  EXPECT_EQ(Shared(1, 4), 0);
}

TEST_F(MapClassesTest, CulledKeyFramesLeaveTheirVotes) {
  const MapPointId id = AddPoint();
  for (uint64_t keyframe = 1; keyframe <= 3; ++keyframe) See(id, keyframe, 0);
  See(id, 4, 4);
  See(id, 5, 4);
  map_.RemoveKeyFrame(KeyFrameId(2));
  map_.RemoveKeyFrame(KeyFrameId(3));
  EXPECT_EQ(At(id).observations.size(), 3U);
  EXPECT_EQ(At(id).votes.ToVector(), (std::vector<ClassVote>{{kBuilding, 3}, {kVehicles, 2}}));
  EXPECT_EQ(At(id).semantic_class, kBuilding);
}

TEST_F(MapClassesTest, MergingAddsAllVotesUp) {
  const MapPointId kept = AddPoint();
  See(kept, 1, 0);
  See(kept, 2, 0);
  const MapPointId dropped = AddPoint();
  See(dropped, 2, 4);  // keyframe 2 sees both
  See(dropped, 3, 4);
  See(dropped, 4, 4);
  map_.MergePoints(kept, dropped);
  EXPECT_EQ(At(kept).observations.size(), 4U);
  EXPECT_EQ(At(kept).votes.ToVector(), (std::vector<ClassVote>{{kBuilding, 2}, {kVehicles, 3}}));
  EXPECT_FALSE(At(kept).active);
  EXPECT_EQ(Shared(1, 2), 0);
}

TEST_F(MapClassesTest, RemovedInactivePointsLeaveNoTrace) {
  const MapPointId seen = AddPoint();
  See(seen, 1, 0);
  See(seen, 2, 0);
  const MapPointId id = AddPoint();
  See(id, 1, 4);
  See(id, 2, 4);
  EXPECT_EQ(Shared(1, 2), 1);
  map_.RemovePoint(id);
  EXPECT_EQ(Shared(1, 2), 1);
  EXPECT_EQ(map_.CountPoints(KeyFrameId(1), 2), 1);
}

TEST_F(MapClassesTest, ViewsHoldActivePointsOnlyWithTheirClass) {
  const MapPointId building = AddPoint();
  See(building, 4, 0);
  See(building, 5, 0);
  const MapPointId vehicle = AddPoint();
  See(vehicle, 4, 4);
  See(vehicle, 5, 4);
  const auto view = MakeLocalMapView(map_, KeyFrameId(5), 1, LocalMapViewLimits());
  ASSERT_EQ(view->ids, std::vector<MapPointId>{building});
  EXPECT_EQ(view->classes, std::vector<uint8_t>{kBuilding});
  EXPECT_EQ(view->reference().point_of_keypoint[4], -1);
  EXPECT_EQ(view->reference().point_of_keypoint[0], 0);
}

TEST_F(MapClassesTest, RecordsCarryClassShareAndVotesThroughTheRestorer) {
  const MapPointId id = AddPoint();
  See(id, 1, 4);
  See(id, 2, 4);
  See(id, 3, 0);
  See(id, 4, 4);
  map_.RemoveKeyFrame(KeyFrameId(2));
  const MapDelta delta = map_.TakeDelta();
  ASSERT_EQ(delta.upserted_points.size(), 1U);
  const MapPointRecord& record = delta.upserted_points[0];
  EXPECT_EQ(record.semantic_class, kVehicles);
  EXPECT_FLOAT_EQ(record.class_confidence, 0.75F);
  EXPECT_EQ(record.votes, (std::vector<ClassVote>{{kVehicles, 3}, {kBuilding, 1}}));

  MapRestorer restorer(ScalePyramidInfo(8, 1.2), id, PointClassPolicy{true, ClassSet(kInactiveClasses)});
  ASSERT_TRUE(restorer.AddPoint(record).ok());
  for (const KeyFrameRecord& keyframe : delta.added_keyframes)
    ASSERT_TRUE(restorer.AddKeyFrame(keyframe, kBounds, map_.FindKeyFrame(keyframe.id)->points).ok());
  const auto restored = std::move(restorer).Finish();
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ(restored->FindPoint(id)->votes.ToVector(), record.votes);
  EXPECT_FALSE(restored->FindPoint(id)->active);
  EXPECT_TRUE(restored->FindKeyFrame(KeyFrameId(1))->covisible.empty());
}

TEST(MapClassPolicyTest, TheFirstLabelStaysWithoutVotes) {
  Map map(ScalePyramidInfo(8, 1.2), PointClassPolicy{false, ClassSet(kInactiveClasses)});
  for (uint64_t id = 1; id <= 3; ++id) map.AddKeyFrame(MakeKeyFrame(id, kBuilding, kVehicles));
  const MapPointId id = map.AddPoint({0, 0, 20}, KeyFrameId(1));
  map.AddObservation(id, KeyFrameId(1), 0);
  map.AddObservation(id, KeyFrameId(2), 4);
  map.AddObservation(id, KeyFrameId(3), 4);
  EXPECT_EQ(map.FindPoint(id)->semantic_class, kBuilding);
  EXPECT_TRUE(map.FindPoint(id)->active);
}

TEST(MapClassPolicyTest, WithoutAPolicyEveryPointIsActive) {
  Map map(ScalePyramidInfo(8, 1.2));
  for (uint64_t id = 1; id <= 2; ++id) map.AddKeyFrame(MakeKeyFrame(id, kBuilding, kVehicles));
  const MapPointId id = map.AddPoint({0, 0, 20}, KeyFrameId(1));
  map.AddObservation(id, KeyFrameId(1), 4);
  map.AddObservation(id, KeyFrameId(2), 4);
  EXPECT_EQ(map.FindPoint(id)->semantic_class, kVehicles);
  EXPECT_NE(map.FindActivePoint(id), nullptr);
}

}  // namespace
}  // namespace semmap
