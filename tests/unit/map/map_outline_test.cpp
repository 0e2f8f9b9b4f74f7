#include "slam/map/map_outline.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

std::vector<MapPointId> Points(const std::vector<uint64_t>& ids) {
  std::vector<MapPointId> points;
  for (const uint64_t id : ids) points.emplace_back(id);
  return points;
}

std::vector<uint64_t> IdsOf(const MapOutline& outline, uint32_t slot) {
  std::vector<uint64_t> ids;
  for (const uint32_t index : outline.PointsOf(slot)) ids.push_back(outline.PointId(index).value());
  return ids;
}

std::vector<uint32_t> ObserversOf(const MapOutline& outline, uint64_t point) {
  const auto observers = outline.ObserversOf(outline.IndexOf(MapPointId(point)).value());
  return {observers.begin(), observers.end()};
}

TEST(MapOutlineTest, SaysWhoSeesWhat) {
  MapOutlineBuilder builder(3, MapPointId(1000));
  const SE3 pose(Eigen::Quaterniond::Identity(), {1, 2, 3});
  ASSERT_TRUE(builder.Add(KeyFrameId(2), pose, Points({7, 1000, 64, 63})).ok());
  ASSERT_TRUE(builder.Add(KeyFrameId(5), pose, {}).ok());
  ASSERT_TRUE(builder.Add(KeyFrameId(9), pose, Points({1000, 8, 7})).ok());
  const size_t expected_bytes = builder.MemoryBytes();
  const MapOutline outline = std::move(builder).Finish();
  EXPECT_EQ(outline.keyframe_count(), 3U);
  EXPECT_EQ(outline.point_count(), 5U);
  EXPECT_EQ(outline.SlotOf(KeyFrameId(9)), 2U);
  EXPECT_FALSE(outline.SlotOf(KeyFrameId(3)).has_value());
  EXPECT_FALSE(outline.SlotOf(KeyFrameId(10)).has_value());
  EXPECT_EQ(outline.places()[0].camera_from_map.translation(), Eigen::Vector3d(-1, -2, -3));
  EXPECT_EQ(IdsOf(outline, 0), (std::vector<uint64_t>{7, 1000, 64, 63})) << "in the order of keypoints";
  EXPECT_TRUE(IdsOf(outline, 1).empty());
  EXPECT_EQ(ObserversOf(outline, 1000), (std::vector<uint32_t>{0, 2}));
  EXPECT_EQ(ObserversOf(outline, 64), std::vector<uint32_t>{0});
  EXPECT_EQ(ObserversOf(outline, 8), std::vector<uint32_t>{2});
  for (const uint64_t absent : {1, 9, 65, 999, 1001, 100'000})
    EXPECT_FALSE(outline.IndexOf(MapPointId(absent)).has_value()) << absent;
  EXPECT_GE(outline.MemoryBytes(), 7 * 2 * sizeof(uint32_t));
  EXPECT_GT(expected_bytes, 0U);
}

TEST(MapOutlineTest, RefusesWhatContradictsItself) {
  MapOutlineBuilder builder(2, MapPointId(10));
  ASSERT_TRUE(builder.Add(KeyFrameId(2), SE3(), Points({10})).ok());
  EXPECT_TRUE(absl::IsDataLoss(builder.Add(KeyFrameId(2), SE3(), {})));
  EXPECT_TRUE(absl::IsDataLoss(builder.Add(KeyFrameId(3), SE3(), Points({11}))));
  EXPECT_TRUE(absl::IsDataLoss(builder.Add(KeyFrameId(3), SE3(), Points({0}))));
}

TEST(MapOutlineTest, KnowsBeforehandThatIdsLieFarApart) {
  const MapOutlineBuilder builder(1, MapPointId(uint64_t{1} << 39));
  EXPECT_GT(builder.MemoryBytes(), size_t{1} << 36) << "a table of ids; who has not so much must not finish";
}

TEST(MapOutlineTest, OfAnEmptyMapIsEmpty) {
  const MapOutline outline = MapOutlineBuilder(0, MapPointId()).Finish();
  EXPECT_EQ(outline.keyframe_count(), 0U);
  EXPECT_FALSE(outline.IndexOf(MapPointId(1)).has_value());
}

}  // namespace
}  // namespace semmap
