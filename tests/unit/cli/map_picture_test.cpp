#include "client/cli/map_picture.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "client/cli/map_projection.h"

namespace semmap::client {
namespace {

constexpr uint8_t kBuilding = 1;
constexpr uint8_t kRoad = 7;
constexpr uint8_t kVegetation = 9;

// A street along the map's z: road below, a house on its right, trees on its left.
MapScene Street() {
  MapScene scene;
  for (int i = 0; i < 200; ++i) {
    const auto z = static_cast<float>(0.5 * i);
    scene.points.push_back({{0, 1.5F, z}, kRoad});
    scene.points.push_back({{10, -3, z}, kBuilding});
    scene.points.push_back({{-10, -2, z}, kVegetation});
  }
  scene.paths.push_back({"car", {}});
  for (int i = 0; i < 100; ++i) scene.paths.back().positions.emplace_back(0, 0, i);
  return scene;
}

int CountColour(const cv::Mat& picture, const cv::Scalar& colour) {
  cv::Mat mask;
  cv::inRange(picture, colour, colour, mask);
  return cv::countNonZero(mask);
}

cv::Point MiddleOf(const cv::Mat& picture, const cv::Scalar& colour) {
  cv::Mat mask;
  cv::inRange(picture, colour, colour, mask);
  const cv::Moments moments = cv::moments(mask, true);
  return {cvRound(moments.m10 / moments.m00), cvRound(moments.m01 / moments.m00)};
}

TEST(GroundFrame, OfACameraMapTakesXAndZ) {
  const GroundFrame frame(-Eigen::Vector3d::UnitY());
  EXPECT_TRUE(frame.FromMap({1, 2, 3}).isApprox(Eigen::Vector3d(1, 3, -2)));
}

TEST(GroundFrame, IsARotationForAnyUp) {
  for (const Eigen::Vector3d& up :
       {Eigen::Vector3d(1, 0.1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.2, -1, 0.3)}) {
    const GroundFrame frame(up.normalized());
    Eigen::Matrix3d rotation;
    for (int i = 0; i < 3; ++i) rotation.col(i) = frame.FromMap(Eigen::Vector3d::Unit(i));
    EXPECT_TRUE((rotation * rotation.transpose()).isIdentity(1e-12));
    EXPECT_NEAR(rotation.determinant(), 1, 1e-12);
    EXPECT_TRUE(frame.FromMap(up.normalized()).isApprox(Eigen::Vector3d::UnitZ()));
  }
}

TEST(PutOnGround, LeavesOutWhatIsFarOff) {
  MapScene scene = Street();
  scene.points.push_back({{0, 0, 5000}, kBuilding});
  scene.points.push_back({{0, -900, 50}, kBuilding});
  const GroundScene drawn = PutOnGround(scene);
  EXPECT_EQ(drawn.left_out, 2U);
  EXPECT_EQ(drawn.points.size(), 600U);
  EXPECT_NEAR(drawn.box.max().y(), 99.5, 1e-3);
  EXPECT_NEAR(drawn.ground_height, -1.5, 1e-6);
  EXPECT_EQ(CountClasses(drawn)[kRoad], 200U);
}

TEST(PutOnGround, KeepsPathsHoweverFarTheyGo) {
  MapScene scene = Street();
  scene.paths.push_back({"bus", {{300, 0, 0}}});
  EXPECT_NEAR(PutOnGround(scene).box.max().x(), 300, 1e-9);
}

TEST(PutOnGround, AnEmptyMapHasABoxToo) {
  const GroundScene drawn = PutOnGround(MapScene());
  EXPECT_GT(drawn.box.volume(), 0);
}

TEST(MapProjection, BothViewsFitTheBoxIntoTheArea) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-20, 5, -2), Eigen::Vector3d(100, 40, 15));
  const cv::Rect area(10, 20, 800, 400);
  for (const MapProjection& view : {MapProjection::Top(box, area), MapProjection::Perspective(box, area)}) {
    for (int i = 0; i < 8; ++i) {
      const auto pixel = view.Project(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
      ASSERT_TRUE(pixel.has_value());
      EXPECT_TRUE(area.contains(cv::Point(pixel->at))) << pixel->at;
    }
  }
}

TEST(MapProjection, UpIsUpAndRightIsRight) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, 40, 10));
  const cv::Rect area(0, 0, 800, 400);
  const Eigen::Vector3d middle(50, 20, 5);
  const MapProjection top = MapProjection::Top(box, area);
  EXPECT_LT(top.Project(middle + Eigen::Vector3d(0, 5, 0))->at.y, top.Project(middle)->at.y);
  EXPECT_GT(top.Project(middle + Eigen::Vector3d(5, 0, 0))->at.x, top.Project(middle)->at.x);
  EXPECT_GT(top.Project(middle + Eigen::Vector3d(0, 0, 5))->nearness, top.Project(middle)->nearness);
  const MapProjection oblique = MapProjection::Perspective(box, area);
  EXPECT_LT(oblique.Project(middle + Eigen::Vector3d(0, 0, 5))->at.y, oblique.Project(middle)->at.y);
  EXPECT_GT(oblique.Project(middle + Eigen::Vector3d(5, 0, 0))->at.x, oblique.Project(middle)->at.x);
  EXPECT_FALSE(oblique.Project({50, -1000, 1000}).has_value()) << "behind who looks";
}

TEST(RoundLength, IsTheLongestRoundOneThatFits) {
  EXPECT_DOUBLE_EQ(RoundLength(99), 50);
  EXPECT_DOUBLE_EQ(RoundLength(100), 100);
  EXPECT_DOUBLE_EQ(RoundLength(4.9), 2);
  EXPECT_DOUBLE_EQ(RoundLength(0.013), 0.01);
}

TEST(MapPicture, ShowsClassesWhereTheyAre) {
  MapPictureOptions options;
  options.view = MapView::kTop;
  const cv::Mat picture = DrawMapPicture(PutOnGround(Street()), options);
  ASSERT_EQ(picture.cols, options.width);
  // Of the legend's squares as well, which are one size.
  const cv::Mat map = picture.colRange(0, options.width - 270);
  for (const uint8_t id : {kBuilding, kVegetation})
    EXPECT_GT(CountColour(map, ClassColour(id)), 200) << int{id};
  EXPECT_LT(MiddleOf(map, ClassColour(kVegetation)).x, MiddleOf(map, ClassColour(kBuilding)).x);
  EXPECT_GT(CountColour(picture, ClassColour(kRoad)), 100);
}

TEST(MapPicture, BothViewsAndNothingToShow) {
  const cv::Mat both = DrawMapPicture(PutOnGround(Street()), {});
  MapPictureOptions top;
  top.view = MapView::kTop;
  EXPECT_GT(CountColour(both, ClassColour(kBuilding)), 400);
  EXPECT_FALSE(DrawMapPicture(PutOnGround(MapScene()), top).empty());
}

}  // namespace
}  // namespace semmap::client
