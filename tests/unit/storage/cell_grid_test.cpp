#include "storage/cell_grid.h"

#include <random>

#include "gtest/gtest.h"

namespace semmap::storage {
namespace {

TEST(CellGrid, CellsAreHalfOpenCubes) {
  EXPECT_EQ(CellOf({0, 0, 0}, 8), Cell(0, 0, 0));
  EXPECT_EQ(CellOf({7.999, -0.001, 8}, 8), Cell(0, -1, 1));
  EXPECT_EQ(CellOf({-8, -8.001, 24}, 8), Cell(-1, -2, 3));
  EXPECT_EQ(CellOf({0.3, 0, 0}, 0.25), Cell(1, 0, 0));
}

TEST(CellGrid, FarAwayIsTheOutermostCell) {
  const int last = kCellLimit - 1;
  EXPECT_EQ(CellOf({1e300, -1e300, 0}, 0.5), Cell(last, -last, 0));
}

TEST(CellGrid, KeysAreExactAndDistinct) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> any(-(kCellLimit - 1), kCellLimit - 1);
  for (int i = 0; i < 1000; ++i) {
    const Cell cell(any(random), any(random), any(random));
    EXPECT_GE(PackCell(cell), 0);
    EXPECT_EQ(UnpackCell(PackCell(cell)), cell);
  }
  EXPECT_NE(PackCell({1, 0, 0}), PackCell({0, 1, 0}));
}

TEST(CellGrid, SizeFollowsTheViewingDistances) {
  const auto points = [](float distance) {
    std::vector<MapPointRecord> result(9);
    for (MapPointRecord& point : result) point.max_distance = distance;
    result[0].max_distance = 1e6F;  // an outlier does not matter
    result[1].max_distance = 0;
    return result;
  };
  EXPECT_EQ(ChooseCellSize(points(35)), 8);
  EXPECT_EQ(ChooseCellSize(points(1.5F)), 0.5);
  EXPECT_EQ(ChooseCellSize(points(1e-9F)), std::exp2(-10));
  EXPECT_EQ(ChooseCellSize(points(1e9F)), 1024);
  EXPECT_EQ(ChooseCellSize({}), 8);
}

}  // namespace
}  // namespace semmap::storage
