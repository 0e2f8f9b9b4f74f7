#include "slam/map/map.h"

#include <gtest/gtest.h>

#include "slam/map/local_map_view.h"

namespace semmap {
namespace {

constexpr int kKeypoints = 40;

KeyFrame MakeKeyFrame(uint64_t id, double z) {
  auto features = std::make_shared<FrameFeatures>();
  for (int i = 0; i < kKeypoints; ++i) {
    Keypoint keypoint;
    keypoint.x = static_cast<float>(10 * i);
    keypoint.y = static_cast<float>(id);
    features->keypoints.push_back(keypoint);
    Descriptor descriptor;
    descriptor.words[0] = static_cast<uint64_t>(i);
    features->descriptors.push_back(descriptor);
  }
  KeyFrame keyframe;
  keyframe.id = KeyFrameId(id);
  keyframe.sequence = id;
  keyframe.timestamp = static_cast<TimestampNs>(id) * 100;
  keyframe.camera_from_map = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -z));
  keyframe.features = features;
  keyframe.grid = std::make_shared<FeatureGrid>(ImageBounds{0, 0, 400, 100}, features->keypoints);
  keyframe.points.assign(kKeypoints, MapPointId());
  return keyframe;
}

class MapTest : public ::testing::Test {
 protected:
  MapTest() : map_(ScalePyramidInfo(8, 1.2)) {
    for (uint64_t id = 1; id <= 4; ++id) {
      map_.AddKeyFrame(MakeKeyFrame(id, static_cast<double>(id)));
      map_.ChooseParent(KeyFrameId(id));
    }
  }

  // A point that the keyframes see at the same keypoint index.
  MapPointId AddSeenPoint(const std::vector<uint64_t>& keyframes, uint32_t keypoint) {
    const MapPointId id = map_.AddPoint({0.1 * keypoint, 0, 20}, KeyFrameId(keyframes.front()));
    for (const uint64_t keyframe : keyframes)
      EXPECT_TRUE(map_.AddObservation(id, KeyFrameId(keyframe), keypoint));
    map_.UpdateAppearance(id);
    return id;
  }

  int Shared(uint64_t a, uint64_t b) const {
    const auto& covisible = map_.FindKeyFrame(KeyFrameId(a))->covisible;
    const auto found = covisible.find(KeyFrameId(b));
    return found == covisible.end() ? 0 : found->second;
  }

  Map map_;
};

TEST_F(MapTest, CountsSharedPointsBothWays) {
  AddSeenPoint({1, 2}, 0);
  AddSeenPoint({1, 2, 3}, 1);
  EXPECT_EQ(Shared(1, 2), 2);
  EXPECT_EQ(Shared(2, 1), 2);
  EXPECT_EQ(Shared(3, 1), 1);
  EXPECT_EQ(Shared(1, 4), 0);
}

TEST_F(MapTest, RefusesContradictoryObservations) {
  const MapPointId first = AddSeenPoint({1, 2}, 0);
  const MapPointId second = AddSeenPoint({3, 4}, 1);
  EXPECT_FALSE(map_.AddObservation(second, KeyFrameId(1), 0)) << "the keypoint is taken";
  EXPECT_FALSE(map_.AddObservation(first, KeyFrameId(1), 5)) << "the keyframe sees the point already";
  EXPECT_FALSE(map_.AddObservation(first, KeyFrameId(99), 0)) << "no such keyframe";
  EXPECT_FALSE(map_.AddObservation(MapPointId(99), KeyFrameId(3), 7)) << "no such point";
  EXPECT_EQ(map_.FindPoint(first)->observations.size(), 2U);
}

TEST_F(MapTest, PointGoesWithItsLastButOneObservation) {
  const MapPointId id = AddSeenPoint({1, 2, 3}, 0);
  map_.RemoveObservation(id, KeyFrameId(1));
  ASSERT_NE(map_.FindPoint(id), nullptr);
  EXPECT_EQ(map_.FindPoint(id)->reference_keyframe, KeyFrameId(2));
  map_.RemoveObservation(id, KeyFrameId(2));
  EXPECT_EQ(map_.FindPoint(id), nullptr);
  EXPECT_FALSE(map_.FindKeyFrame(KeyFrameId(3))->points[0].IsValid());
  EXPECT_EQ(Shared(2, 3), 0);
}

TEST_F(MapTest, MergeMovesWhatIsNotSeenTwice) {
  const MapPointId kept = AddSeenPoint({1, 2}, 0);
  const MapPointId dropped = AddSeenPoint({2, 3}, 1);
  map_.MergePoints(kept, dropped);
  EXPECT_EQ(map_.FindPoint(dropped), nullptr);
  ASSERT_EQ(map_.FindPoint(kept)->observations.size(), 3U);
  EXPECT_EQ(map_.FindKeyFrame(KeyFrameId(3))->points[1], kept);
  EXPECT_FALSE(map_.FindKeyFrame(KeyFrameId(2))->points[1].IsValid());
  EXPECT_EQ(Shared(1, 3), 1);
}

TEST_F(MapTest, RemovedKeyFrameLeavesItsFramesToItsParent) {
  AddSeenPoint({1, 2, 3}, 0);
  AddSeenPoint({2, 3}, 1);
  map_.ChooseParent(KeyFrameId(2));
  map_.ChooseParent(KeyFrameId(3));
  map_.TakeDelta();
  ASSERT_EQ(map_.FindKeyFrame(KeyFrameId(3))->parent, KeyFrameId(2));
  map_.RemoveKeyFrame(KeyFrameId(2));
  EXPECT_EQ(map_.FindKeyFrame(KeyFrameId(3))->parent, KeyFrameId(1));
  const MapDelta delta = map_.TakeDelta();
  ASSERT_EQ(delta.removed_keyframes.size(), 1U);
  EXPECT_EQ(delta.removed_keyframes[0].heir, KeyFrameId(1));
  // Keyframes 1 and 2 look along z from z = 1 and z = 2.
  EXPECT_NEAR(delta.removed_keyframes[0].heir_from_removed.translation().z(), 1.0, 1e-12);
  EXPECT_EQ(delta.removed_points.size(), 1U) << "the point that only 2 and 3 saw";
}

TEST_F(MapTest, FirstKeyFrameStays) {
  map_.RemoveKeyFrame(KeyFrameId(1));
  EXPECT_NE(map_.FindKeyFrame(KeyFrameId(1)), nullptr);
}

TEST_F(MapTest, DeltaCarriesChangesOnce) {
  const MapPointId point = AddSeenPoint({1, 2}, 0);
  const MapDelta first = map_.TakeDelta();
  EXPECT_EQ(first.added_keyframes.size(), 4U);
  ASSERT_EQ(first.upserted_points.size(), 1U);
  EXPECT_EQ(first.upserted_points[0].observation_count, 2U);
  EXPECT_EQ(first.upserted_points[0].first_seen, 100);
  EXPECT_EQ(first.upserted_points[0].last_seen, 200);
  EXPECT_TRUE(map_.TakeDelta().empty());
  map_.SetPosition(point, {1, 2, 3});
  map_.SetPose(KeyFrameId(2), SE3());
  const MapDelta second = map_.TakeDelta();
  EXPECT_TRUE(second.added_keyframes.empty());
  EXPECT_EQ(second.moved_keyframes.size(), 1U);
  EXPECT_EQ(second.upserted_points.size(), 1U);
}

TEST_F(MapTest, PointThatCameAndWentLeavesNoTraceInTheDelta) {
  map_.TakeDelta();
  const MapPointId id = AddSeenPoint({1, 2}, 0);
  map_.RemovePoint(id);
  const MapDelta delta = map_.TakeDelta();
  EXPECT_TRUE(delta.upserted_points.empty());
  EXPECT_TRUE(delta.removed_points.empty());
}

TEST_F(MapTest, ClearTellsTheSinkAndKeepsIdsUnique) {
  const MapPointId before = AddSeenPoint({1, 2}, 0);
  map_.Clear();
  const MapDelta delta = map_.TakeDelta();
  EXPECT_TRUE(delta.reset);
  EXPECT_TRUE(delta.added_keyframes.empty());
  map_.AddKeyFrame(MakeKeyFrame(9, 0));
  EXPECT_GT(map_.AddPoint({0, 0, 1}, KeyFrameId(9)), before);
}

TEST_F(MapTest, DescriptorIsTheMostCentralOne) {
  const MapPointId id = map_.AddPoint({0, 0, 20}, KeyFrameId(1));
  // Descriptors 1111, 1000 and 0000: the first is far from both others.
  map_.AddObservation(id, KeyFrameId(1), 15);
  map_.AddObservation(id, KeyFrameId(2), 8);
  map_.AddObservation(id, KeyFrameId(3), 0);
  map_.UpdateAppearance(id);
  EXPECT_EQ(map_.FindPoint(id)->descriptor.words[0], 8U);
}

TEST_F(MapTest, ViewHoldsNewestKeyFrameAndItsSurroundings) {
  const MapPointId shared = AddSeenPoint({3, 4}, 0);
  const MapPointId of_neighbour = AddSeenPoint({2, 3}, 1);
  const MapPointId far = AddSeenPoint({1, 2}, 2);
  const auto view = MakeLocalMapView(map_, map_.newest_keyframe(), 7,
                                     {.neighbours = 5, .second_neighbours = 0, .max_points = 100});
  ASSERT_NE(view, nullptr);
  EXPECT_EQ(view->version, 7U);
  EXPECT_EQ(view->reference().id, KeyFrameId(4));
  EXPECT_GE(view->IndexOf(shared), 0);
  EXPECT_GE(view->IndexOf(of_neighbour), 0);
  EXPECT_EQ(view->IndexOf(far), -1) << "keyframe 4 and 2 share nothing";
  EXPECT_EQ(view->ids[view->reference().point_of_keypoint[0]], shared);
}

TEST(EmptyMapTest, HasNoView) {
  EXPECT_EQ(MakeLocalMapView(Map(ScalePyramidInfo(8, 1.2)), KeyFrameId(1), 1, LocalMapViewLimits()), nullptr);
}

// --- Maps laid beside each other

class MapAppendTest : public MapTest {
 protected:
  // Keyframe i of the piece becomes 10 + i.
  static KeyFrameIdMap NewIds() {
    KeyFrameIdMap ids;
    for (uint64_t id = 1; id <= 4; ++id) ids.emplace(KeyFrameId(id), KeyFrameId(10 + id));
    return ids;
  }
};

TEST_F(MapAppendTest, AppendLaysAPieceBeside) {
  const MapPointId own = AddSeenPoint({1, 2, 3}, 5);
  const Map piece = map_;
  AddSeenPoint({1, 2}, 6);
  map_.TakeDelta();
  map_.Append(piece, NewIds());
  EXPECT_EQ(map_.keyframes().size(), 8U);
  ASSERT_EQ(map_.points().size(), 3U);
  EXPECT_EQ(Shared(11, 13), 1);
  EXPECT_EQ(Shared(1, 11), 0);
  const KeyFrame& added = *map_.FindKeyFrame(KeyFrameId(13));
  EXPECT_EQ(added.parent, KeyFrameId(piece.FindKeyFrame(KeyFrameId(3))->parent.value() + 10));
  EXPECT_FALSE(map_.FindKeyFrame(KeyFrameId(11))->parent.IsValid()) << "a tree of its own";
  const MapPoint& point = *map_.FindPoint(added.points[5]);
  EXPECT_NE(point.id, own);
  EXPECT_EQ(point.observations.size(), 3U);
  EXPECT_EQ(point.reference_keyframe, KeyFrameId(11));
  EXPECT_EQ(point.descriptor, piece.FindPoint(own)->descriptor);
  const MapDelta delta = map_.TakeDelta();
  EXPECT_EQ(delta.added_keyframes.size(), 4U);
  EXPECT_EQ(delta.upserted_points.size(), 1U);
}

TEST_F(MapAppendTest, DropTakesItAwayWithoutATrace) {
  AddSeenPoint({1, 2, 3}, 5);
  const Map piece = map_;
  map_.TakeDelta();
  map_.Append(piece, NewIds());
  map_.Drop({KeyFrameId(11), KeyFrameId(12), KeyFrameId(13), KeyFrameId(14)});
  EXPECT_EQ(map_.keyframes().size(), 4U);
  EXPECT_EQ(map_.points().size(), 1U);
  EXPECT_EQ(map_.newest_keyframe(), KeyFrameId(4));
  EXPECT_TRUE(map_.TakeDelta().empty());
}

}  // namespace
}  // namespace semmap
