#include "server/area_filter.h"

#include <limits>

#include <gtest/gtest.h>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

void AddCorner(v1::Polygon* polygon, double x, double y, double z) {
  v1::Vector3* corner = polygon->add_corners();
  corner->set_x(x);
  corner->set_y(y);
  corner->set_z(z);
}

// An L in the plane of the ground.
v1::Area LShape() {
  v1::Area area;
  v1::Polygon* polygon = area.mutable_polygon();
  AddCorner(polygon, 0, 5, 0);
  AddCorner(polygon, 4, -5, 0);
  AddCorner(polygon, 4, 0, 1);
  AddCorner(polygon, 1, 0, 1);
  AddCorner(polygon, 1, 0, 4);
  AddCorner(polygon, 0, 0, 4);
  return area;
}

bool Holds(const AreaFilter& filter, const Eigen::Vector3d& point) {
  return (!filter.box.has_value() || filter.box->contains(point)) && filter.Contains(point, 1);
}

TEST(AreaFilter, NoAreaHoldsEverything) {
  const auto filter = FromProto(v1::Area());
  ASSERT_TRUE(filter.ok());
  EXPECT_FALSE(filter->box.has_value());
  EXPECT_TRUE(filter->Contains({1e9, 0, 0}, 1));
}

TEST(AreaFilter, PolygonsReachUpAndDown) {
  const auto filter = FromProto(LShape());
  ASSERT_TRUE(filter.ok()) << filter.status();
  EXPECT_TRUE(Holds(*filter, {3, 100, 0.5}));
  EXPECT_TRUE(Holds(*filter, {0.5, -100, 3}));
  EXPECT_FALSE(Holds(*filter, {3, 0, 3}));
  EXPECT_FALSE(Holds(*filter, {5, 0, 0.5}));
}

TEST(AreaFilter, ASphereIsRound) {
  v1::Area area;
  area.mutable_sphere()->set_radius_m(2);
  const auto filter = FromProto(area);
  ASSERT_TRUE(filter.ok());
  EXPECT_TRUE(Holds(*filter, {1.9, 0, 0}));
  EXPECT_FALSE(Holds(*filter, {1.9, 1.9, 0}));
}

TEST(AreaFilter, OnlyTheIdsThatWereFoundOut) {
  AreaFilter filter;
  filter.ids = std::unordered_set<uint64_t>{3, 5};
  EXPECT_TRUE(filter.Contains({0, 0, 0}, 3));
  EXPECT_FALSE(filter.Contains({0, 0, 0}, 4));
}

TEST(AreaFilter, RefusesAreasWithoutInside) {
  v1::Area area;
  area.mutable_sphere()->set_radius_m(0);
  EXPECT_EQ(ReasonOf(FromProto(area).status()), v1::ERROR_REASON_AREA_INVALID);
  area.mutable_sphere()->set_radius_m(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(ReasonOf(FromProto(area).status()), v1::ERROR_REASON_AREA_INVALID);
  area.mutable_box()->mutable_min()->set_x(1);
  area.mutable_box()->mutable_max()->set_x(0);
  EXPECT_EQ(ReasonOf(FromProto(area).status()), v1::ERROR_REASON_AREA_INVALID);
  AddCorner(area.mutable_polygon(), 0, 0, 0);
  EXPECT_EQ(ReasonOf(FromProto(area).status()), v1::ERROR_REASON_AREA_INVALID);
  for (const int count : {0, -1, 100'001}) {
    area.mutable_nearest()->set_count(count);
    EXPECT_EQ(ReasonOf(FromProto(area).status()), v1::ERROR_REASON_AREA_INVALID) << count;
  }
  area.mutable_nearest()->set_count(3);
  area.mutable_nearest()->mutable_point()->set_x(std::numeric_limits<double>::infinity());
  EXPECT_EQ(ReasonOf(FromProto(area).status()), v1::ERROR_REASON_AREA_INVALID);
}

}  // namespace
}  // namespace semmap::server
