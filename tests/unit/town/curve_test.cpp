#include "client/town/curve.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace semmap::town {
namespace {

Path Circle(double radius) {
  std::vector<glm::dvec2> points;
  for (int i = 0; i <= 360; ++i) {
    const double angle = i * std::numbers::pi / 180;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return Path(points);
}

TEST(Path, MeasuresACircle) {
  const Path circle = Circle(20);
  EXPECT_NEAR(circle.length(), 2 * std::numbers::pi * 20, 0.02);
  EXPECT_NEAR(circle.CurvatureAt(30), 1.0 / 20, 1e-3);
  EXPECT_NEAR(glm::length(circle.PointAt(17.3)), 20, 0.01);
}

TEST(Path, OffsetToTheLeftOfACircleShrinksIt) {
  EXPECT_NEAR(Circle(20).Offset(2).length(), 2 * std::numbers::pi * 18, 0.05);
}

TEST(Path, ReversedRunsBackwards) {
  const Path path({{0, 0}, {4, 0}, {4, 3}});
  EXPECT_EQ(path.Reversed().PointAt(3), path.PointAt(4));
  EXPECT_LT(path.Reversed().TangentAt(6.9).x, 0);
}

TEST(Path, SliceAndAppendKeepLengths) {
  const Path path({{0, 0}, {4, 0}, {4, 3}});
  Path front = path.Slice(1, 3);
  EXPECT_NEAR(front.length(), 2, 1e-12);
  front.Append(path.Slice(3, 6));
  EXPECT_NEAR(front.length(), 5, 1e-12);
  EXPECT_EQ(front.PointAt(4), path.PointAt(5));
}

TEST(Path, ProjectFindsTheNearestPoint) {
  const Path path({{0, 0}, {10, 0}, {10, 10}});
  EXPECT_NEAR(path.Project({3, 5}), 3, 1e-12);
  EXPECT_NEAR(path.Project({14, 6}), 16, 1e-12);
}

TEST(Path, ClampsOutsideOfItsLength) {
  const Path path({{0, 0}, {10, 0}});
  EXPECT_EQ(path.PointAt(-5), glm::dvec2(0, 0));
  EXPECT_EQ(path.PointAt(99), glm::dvec2(10, 0));
}

}  // namespace
}  // namespace semmap::town
