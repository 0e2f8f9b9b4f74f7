#include "tests/bench/experiment/map_census.h"

#include <gtest/gtest.h>

namespace semmap::bench {
namespace {

constexpr uint8_t kBuilding = 1;
constexpr uint8_t kPedestrian = 4;
constexpr uint8_t kVehicles = 10;

TEST(TruthLabelTest, FitsInAByte) {
  for (const TruthLabel label :
       {TruthLabel{kBuilding, false, false}, TruthLabel{kVehicles, true, false}, TruthLabel{22, true, true}})
    EXPECT_EQ(DecodeLabel(Encode(label)), label);
}

TEST(MostFrequentTest, FirstOfEquals) {
  EXPECT_EQ(MostFrequent({7, 9, 9, 7}), 7);
  EXPECT_EQ(MostFrequent({7, 9, 9}), 9);
}

// Frames of 4 x 1 pixels: a wall, a driving vehicle, a parked one, a pedestrian.
class CensusTest : public ::testing::Test {
 protected:
  CensusTest()
      : sink_(
            [](uint64_t sequence) {
              cv::Mat labels(1, 4, CV_8UC1);
              labels.at<uint8_t>(0, 0) = Encode({kBuilding, false, false});
              // It stops now and then.
              labels.at<uint8_t>(0, 1) = Encode({kVehicles, true, sequence % 2 == 0});
              labels.at<uint8_t>(0, 2) = Encode({kVehicles, false, false});
              labels.at<uint8_t>(0, 3) = Encode({kPedestrian, true, true});
              return labels;
            },
            ClassSet(kInactiveClasses)) {}

  // A keyframe whose keypoints lie on all four, seen as `classes`, and see points 1 to 4.
  void AddKeyFrame(uint64_t id, const std::vector<uint8_t>& classes) {
    auto features = std::make_shared<FrameFeatures>();
    features->keypoints.resize(4);
    features->descriptors.resize(4);
    for (size_t i = 0; i < 4; ++i) {
      features->keypoints[i].x = static_cast<float>(i);
      features->keypoints[i].semantic_class = classes[i];
    }
    KeyFrameRecord record;
    record.id = KeyFrameId(id);
    record.sequence = id;
    record.features = features;
    delta_.added_keyframes.push_back(record);
    delta_.observations.push_back(
        {record.id, {MapPointId(1), MapPointId(2), MapPointId(3), MapPointId(4)}, features});
  }
  void AddPoint(uint64_t id, uint8_t semantic_class) {
    MapPointRecord record;
    record.id = MapPointId(id);
    record.semantic_class = semantic_class;
    delta_.upserted_points.push_back(record);
  }

  MapDelta delta_;
  CensusSink sink_;
};

TEST_F(CensusTest, CountsWhatPointsAreOnAndWhoIsRight) {
  AddKeyFrame(1, {kBuilding, kVehicles, kVehicles, kBuilding});
  AddKeyFrame(2, {kVehicles, kVehicles, kBuilding, kPedestrian});
  AddPoint(1, kBuilding);
  AddPoint(2, kVehicles);
  AddPoint(3, kBuilding);  // a parked vehicle taken for a building stays active
  AddPoint(4, kBuilding);  // so does a pedestrian
  sink_.OnDelta(delta_);
  const MapCensus census = sink_.TakeCensus();
  EXPECT_EQ(census.all.points, 4U);
  EXPECT_EQ(census.all.on_traffic_vehicles, 1U);
  EXPECT_EQ(census.all.on_parked_vehicles, 1U);
  EXPECT_EQ(census.all.on_pedestrians, 1U);
  EXPECT_EQ(census.active.points, 3U);
  EXPECT_EQ(census.active.on_traffic_vehicles, 0U);
  EXPECT_EQ(census.active.on_pedestrians, 1U);
  EXPECT_EQ(census.classes[kBuilding].correct, 1U);
  EXPECT_EQ(census.classes[kBuilding].labels, 2U);
  EXPECT_EQ(census.classes[kBuilding].correct_labels, 1U);
  EXPECT_EQ(census.classes[kVehicles].points, 1U) << "the inactive one does not count";
  EXPECT_EQ(census.classes[kVehicles].correct, 0U);
  EXPECT_EQ(census.keypoints, 8U);
  EXPECT_EQ(census.keypoints_on_traffic, 4U);
}

TEST_F(CensusTest, FollowsRemovalsAndResets) {
  AddKeyFrame(1, {kBuilding, kVehicles, kVehicles, kPedestrian});
  for (uint64_t id = 1; id <= 4; ++id) AddPoint(id, kBuilding);
  sink_.OnDelta(delta_);
  MapDelta removal;
  removal.removed_points = {MapPointId(1)};
  sink_.OnDelta(removal);
  EXPECT_EQ(sink_.TakeCensus().all.points, 3U);
  MapDelta reset;
  reset.reset = true;
  sink_.OnDelta(reset);
  EXPECT_EQ(sink_.TakeCensus().all.points, 0U);
  EXPECT_EQ(sink_.TakeCensus().keypoints, 0U);
}

}  // namespace
}  // namespace semmap::bench
