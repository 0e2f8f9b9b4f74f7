#include "slam/map/map_restorer.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

constexpr ImageBounds kBounds{0, 0, 400, 100};

KeyFrameRecord KeyFrameOf(uint64_t id, uint64_t parent, size_t keypoints = 4) {
  auto features = std::make_shared<FrameFeatures>();
  features->keypoints.resize(keypoints);
  features->descriptors.resize(keypoints);
  KeyFrameRecord record;
  record.id = KeyFrameId(id);
  record.map_from_camera = SE3(Eigen::Quaterniond(1, 0.1, 0, 0), {static_cast<double>(id), 0, 0});
  record.parent = KeyFrameId(parent);
  record.features = features;
  return record;
}

MapPointRecord PointOf(uint64_t id) {
  MapPointRecord record;
  record.id = MapPointId(id);
  record.position_in_map = {1, 2, static_cast<double>(id)};
  record.normal = {0, 0, 1};
  record.min_distance = 3;
  record.max_distance = 9;
  record.descriptor.words[2] = id;
  record.observation_count = 2;
  return record;
}

class MapRestorerTest : public ::testing::Test {
 protected:
  absl::Status AddKeyFrame(const KeyFrameRecord& record, const std::vector<uint64_t>& points) {
    std::vector<MapPointId> observations;
    for (const uint64_t point : points) observations.emplace_back(point);
    return restorer_.AddKeyFrame(record, kBounds, observations);
  }

  MapRestorer restorer_{ScalePyramidInfo(8, 1.2), MapPointId(70)};
};

TEST_F(MapRestorerTest, RestoresBothDirectionsAndCanGoOn) {
  for (const uint64_t point : {5, 6, 9}) ASSERT_TRUE(restorer_.AddPoint(PointOf(point)).ok());
  const size_t bytes_of_points = restorer_.memory_bytes();
  EXPECT_GT(bytes_of_points, 3 * sizeof(MapPoint));
  ASSERT_TRUE(AddKeyFrame(KeyFrameOf(3, 0), {5, 6, 0, 9}).ok());
  ASSERT_TRUE(AddKeyFrame(KeyFrameOf(4, 3), {0, 5, 6, 0}).ok());
  EXPECT_GT(restorer_.memory_bytes(), bytes_of_points + 8 * (sizeof(Keypoint) + sizeof(Descriptor)));
  auto map = std::move(restorer_).Finish();
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_TRUE(map->TakeDelta().empty()) << "nothing has changed since the store had it";
  EXPECT_EQ(map->newest_keyframe(), KeyFrameId(4));
  const KeyFrame& second = *map->FindKeyFrame(KeyFrameId(4));
  EXPECT_EQ(second.parent, KeyFrameId(3));
  EXPECT_EQ(second.covisible.at(KeyFrameId(3)), 2);
  EXPECT_NEAR((second.Center() - Eigen::Vector3d(4, 0, 0)).norm(), 0, 1e-12);
  const MapPoint& point = *map->FindPoint(MapPointId(6));
  ASSERT_EQ(point.observations.size(), 2U);
  EXPECT_EQ(point.observations[1].keyframe, KeyFrameId(4));
  EXPECT_EQ(point.observations[1].keypoint, 2U);
  EXPECT_EQ(point.descriptor.words[2], 6U);
  EXPECT_EQ(point.min_distance, 3);
  EXPECT_GT(map->AddPoint({0, 0, 0}, KeyFrameId(3)), MapPointId(70)) << "ids are never used again";
  map->RemoveKeyFrame(KeyFrameId(3));
  EXPECT_NE(map->FindKeyFrame(KeyFrameId(3)), nullptr) << "the first keyframe stays";
}

TEST_F(MapRestorerTest, RefusesADanglingObservation) {
  ASSERT_TRUE(restorer_.AddPoint(PointOf(5)).ok());
  EXPECT_TRUE(absl::IsDataLoss(AddKeyFrame(KeyFrameOf(1, 0), {5, 6, 0, 0})));
}

TEST_F(MapRestorerTest, RefusesAPointSeenTwiceByOneKeyFrame) {
  ASSERT_TRUE(restorer_.AddPoint(PointOf(5)).ok());
  EXPECT_TRUE(absl::IsDataLoss(AddKeyFrame(KeyFrameOf(1, 0), {5, 0, 5, 0})));
}

TEST_F(MapRestorerTest, RefusesRepetitionsAndWrongLengths) {
  ASSERT_TRUE(restorer_.AddPoint(PointOf(5)).ok());
  EXPECT_TRUE(absl::IsDataLoss(restorer_.AddPoint(PointOf(5))));
  EXPECT_TRUE(absl::IsDataLoss(AddKeyFrame(KeyFrameOf(1, 0), {5, 0, 0})));
  ASSERT_TRUE(AddKeyFrame(KeyFrameOf(1, 0), {5, 0, 0, 0}).ok());
  EXPECT_TRUE(absl::IsDataLoss(AddKeyFrame(KeyFrameOf(1, 0), {0, 0, 0, 0})));
}

TEST_F(MapRestorerTest, RefusesKeypointsBeyondThePyramid) {
  KeyFrameRecord record = KeyFrameOf(1, 0);
  auto features = std::make_shared<FrameFeatures>(*record.features);
  features->keypoints[2].octave = 8;
  record.features = features;
  EXPECT_TRUE(absl::IsDataLoss(AddKeyFrame(record, {0, 0, 0, 0})));
}

TEST_F(MapRestorerTest, RefusesAMissingParent) {
  ASSERT_TRUE(AddKeyFrame(KeyFrameOf(1, 0), {0, 0, 0, 0}).ok());
  ASSERT_TRUE(AddKeyFrame(KeyFrameOf(3, 2), {0, 0, 0, 0}).ok());
  EXPECT_TRUE(absl::IsDataLoss(std::move(restorer_).Finish().status()));
}

TEST_F(MapRestorerTest, NothingIsAnEmptyMap) {
  const auto map = std::move(restorer_).Finish();
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_TRUE(map->keyframes().empty());
}

}  // namespace
}  // namespace semmap
