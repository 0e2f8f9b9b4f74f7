#include "slam/geometry/alignment.h"

#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace semmap {
namespace {

std::vector<Eigen::Vector3d> RandomPoints(int count, double size, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, size);
  std::vector<Eigen::Vector3d> points(count);
  for (Eigen::Vector3d& point : points) point = {normal(random), normal(random), normal(random)};
  return points;
}

Sim3 SomeSim3(double scale) {
  Vector6d tangent;
  tangent << 12, -7, 3, 0.4, -1.9, 1.1;
  return {scale, SE3::Exp(tangent)};
}

std::vector<Eigen::Vector3d> Transform(const Sim3& sim3, const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3d> out;
  out.reserve(points.size());
  for (const Eigen::Vector3d& point : points) out.push_back(sim3 * point);
  return out;
}

double SumOfSquares(const Sim3& sim3, const std::vector<Eigen::Vector3d>& source,
                    const std::vector<Eigen::Vector3d>& target) {
  double sum = 0;
  for (size_t i = 0; i < source.size(); ++i) sum += (target[i] - sim3 * source[i]).squaredNorm();
  return sum;
}

void ExpectSame(const Sim3& actual, const Sim3& expected) {
  EXPECT_NEAR(actual.scale, expected.scale, 1e-9);
  EXPECT_LT((actual.rigid * expected.rigid.Inverse()).Log().norm(), 1e-8);
}

TEST(AlignPoints, RecoversASimilarity) {
  const auto source = RandomPoints(20, 5, 1);
  const auto result = AlignPoints(source, Transform(SomeSim3(3.7), source), true);
  ASSERT_TRUE(result.ok());
  ExpectSame(*result, SomeSim3(3.7));
}

TEST(AlignPoints, RecoversARigidMotion) {
  const auto source = RandomPoints(3, 5, 2);
  const auto result = AlignPoints(source, Transform(SomeSim3(1), source), false);
  ASSERT_TRUE(result.ok());
  ExpectSame(*result, SomeSim3(1));
  EXPECT_EQ(result->scale, 1.0);
}

TEST(AlignPoints, RecoversFromAPlane) {
  auto source = RandomPoints(30, 5, 3);
  for (Eigen::Vector3d& point : source) point.y() = 0;
  const auto result = AlignPoints(source, Transform(SomeSim3(0.2), source), true);
  ASSERT_TRUE(result.ok());
  ExpectSame(*result, SomeSim3(0.2));
}

TEST(AlignPoints, KeepsDigitsFarFromTheOrigin) {
  auto source = RandomPoints(50, 100, 4);
  const auto target = Transform(SomeSim3(1), source);
  for (Eigen::Vector3d& point : source) point += Eigen::Vector3d(4e5, 5e6, 100);  // as UTM has them
  const auto result = AlignPoints(source, target, true);
  ASSERT_TRUE(result.ok());
  EXPECT_LT(std::sqrt(SumOfSquares(*result, source, target) / 50), 1e-6);
}

TEST(AlignPoints, IsTheLeastSquaresOptimum) {
  const auto source = RandomPoints(40, 5, 5);
  auto target = Transform(SomeSim3(2), source);
  const auto noise = RandomPoints(40, 0.5, 6);
  for (size_t i = 0; i < target.size(); ++i) target[i] += noise[i];
  for (const bool with_scale : {false, true}) {
    const auto best = AlignPoints(source, target, with_scale);
    ASSERT_TRUE(best.ok());
    const double cost = SumOfSquares(*best, source, target);
    for (int axis = 0; axis < 6; ++axis) {
      for (const double step : {-1e-3, 1e-3}) {
        const Sim3 moved{best->scale, SE3::Exp(step * Vector6d::Unit(axis)) * best->rigid};
        EXPECT_GT(SumOfSquares(moved, source, target), cost);
      }
    }
    if (!with_scale) continue;
    EXPECT_GT(SumOfSquares({best->scale * 1.001, best->rigid}, source, target), cost);
    EXPECT_GT(SumOfSquares({best->scale / 1.001, best->rigid}, source, target), cost);
  }
}

TEST(AlignPoints, NeverReflects) {
  const auto source = RandomPoints(10, 5, 7);
  auto target = source;
  for (Eigen::Vector3d& point : target) point.x() = -point.x();
  const auto result = AlignPoints(source, target, true);
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->rigid.RotationMatrix().determinant(), 1, 1e-9);
  EXPECT_GT(SumOfSquares(*result, source, target), 1);
}

TEST(AlignPoints, RefusesDegenerateInput) {
  const auto few = RandomPoints(2, 5, 8);
  EXPECT_FALSE(AlignPoints(few, few, true).ok());
  const auto three = RandomPoints(3, 5, 8);
  EXPECT_FALSE(AlignPoints(three, few, true).ok());
  const std::vector<Eigen::Vector3d> one_place(5, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(AlignPoints(one_place, one_place, true).ok());
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < 10; ++i) line.emplace_back(1 + 0.1 * i, 2 - 0.7 * i, 0.3 * i);
  EXPECT_FALSE(AlignPoints(line, line, true).ok());
  auto broken = three;
  broken[1].y() = std::numeric_limits<double>::quiet_NaN();
  const auto result = AlignPoints(broken, three, true);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace semmap
