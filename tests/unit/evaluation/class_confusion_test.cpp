#include "slam/evaluation/class_confusion.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

constexpr uint8_t kBuilding = 1;
constexpr uint8_t kRoadLine = 6;
constexpr uint8_t kRoad = 7;
constexpr uint8_t kSky = 13;

cv::Mat Row(std::vector<uint8_t> ids) { return cv::Mat(ids, true).reshape(1, 1); }

TEST(ClassConfusion, CountsWhatTheDefinitionSays) {
  ClassConfusion confusion(*FindClassMerge("none"));
  // Road: 2 hits of 3 labelled, predicted 3 times; Sky: 1 of 2, predicted once; Building never labelled.
  ASSERT_TRUE(confusion
                  .Add(Row({kRoad, kRoad, kRoad, kSky, kSky, 0, kUnknownClass}),
                       Row({kRoad, kRoad, kBuilding, kRoad, kSky, kRoad, kRoad}))
                  .ok());
  EXPECT_EQ(confusion.pixels(), 5);
  EXPECT_DOUBLE_EQ(*confusion.IntersectionOverUnion(kRoad), 2.0 / 4);
  EXPECT_DOUBLE_EQ(*confusion.Accuracy(kRoad), 2.0 / 3);
  EXPECT_DOUBLE_EQ(*confusion.IntersectionOverUnion(kSky), 1.0 / 2);
  EXPECT_FALSE(confusion.IntersectionOverUnion(kBuilding).has_value());
  EXPECT_FALSE(confusion.Accuracy(0).has_value());
  EXPECT_EQ(confusion.ClassesPresent(), 2);
  EXPECT_DOUBLE_EQ(confusion.MeanIoU(), 0.5);
  EXPECT_DOUBLE_EQ(confusion.PixelAccuracy(), 3.0 / 5);
}

TEST(ClassConfusion, ImagesAddUp) {
  ClassConfusion confusion(*FindClassMerge("none"));
  ASSERT_TRUE(confusion.Add(Row({kRoad}), Row({kRoad})).ok());
  ASSERT_TRUE(confusion.Add(Row({kRoad, kRoad, kRoad}), Row({kSky, kSky, kUnknownClass})).ok());
  EXPECT_DOUBLE_EQ(*confusion.Accuracy(kRoad), 0.25);
}

TEST(ClassConfusion, ThePredictionCountsAsWhatTheLabelsCallIt) {
  ClassConfusion fine(*FindClassMerge("none"));
  ClassConfusion coarse(*FindClassMerge("camvid11"));
  ASSERT_TRUE(fine.Add(Row({kRoad, kRoad}), Row({kRoad, kRoadLine})).ok());
  ASSERT_TRUE(coarse.Add(Row({kRoad, kRoad}), Row({kRoad, kRoadLine})).ok());
  EXPECT_DOUBLE_EQ(*fine.Accuracy(kRoad), 0.5);
  EXPECT_DOUBLE_EQ(*coarse.Accuracy(kRoad), 1.0);
  EXPECT_EQ((*FindClassMerge("carla"))[18], 12);
  EXPECT_FALSE(FindClassMerge("cityscapes").ok());
}

TEST(ClassConfusion, RefusesWhatIsNoMask) {
  ClassConfusion confusion(*FindClassMerge("none"));
  EXPECT_FALSE(confusion.Add(Row({kRoad}), Row({kRoad, kRoad})).ok());
  EXPECT_FALSE(confusion.Add(Row({100}), Row({kRoad})).ok());
  EXPECT_FALSE(confusion.Add(cv::Mat(1, 1, CV_8UC3), cv::Mat(1, 1, CV_8UC3)).ok());
  EXPECT_EQ(confusion.MeanIoU(), 0);
}

}  // namespace
}  // namespace semmap
