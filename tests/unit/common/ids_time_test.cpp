#include <type_traits>
#include <unordered_map>

#include <gtest/gtest.h>

#include "slam/common/ids.h"
#include "slam/common/status_macros.h"
#include "slam/common/time.h"

namespace semmap {
namespace {

TEST(StrongId, KindsDoNotMix) {
  static_assert(!std::is_convertible_v<KeyFrameId, MapPointId>);
  static_assert(!std::is_convertible_v<uint64_t, KeyFrameId>);
  EXPECT_FALSE(KeyFrameId().IsValid());
  EXPECT_TRUE(KeyFrameId(3).IsValid());
  EXPECT_LT(KeyFrameId(3), KeyFrameId(4));
  std::unordered_map<MapPointId, int, IdHash> map;
  map[MapPointId(7)] = 1;
  EXPECT_TRUE(map.contains(MapPointId(7)));
  EXPECT_FALSE(map.contains(MapPointId(8)));
}

TEST(Time, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(FromSeconds(1.5), 1500000000);
  EXPECT_EQ(FromSeconds(-1.5), -1500000000);
  EXPECT_EQ(FromSeconds(0.1), 100000000);
  EXPECT_DOUBLE_EQ(ToSeconds(2500000000), 2.5);
}

absl::StatusOr<int> Half(int value) {
  if (value % 2 != 0) return absl::InvalidArgumentError("odd");
  return value / 2;
}

absl::StatusOr<int> Quarter(int value) {
  SEMMAP_ASSIGN_OR_RETURN(const int half, Half(value));
  SEMMAP_ASSIGN_OR_RETURN(const int quarter, Half(half));
  return quarter;
}

absl::Status CheckQuarter(int value) {
  SEMMAP_RETURN_IF_ERROR(Quarter(value).status());
  return absl::OkStatus();
}

TEST(StatusMacros, PassOnErrorsAndValues) {
  EXPECT_EQ(Quarter(12).value(), 3);
  EXPECT_EQ(Quarter(6).status().message(), "odd");
  EXPECT_TRUE(CheckQuarter(8).ok());
  EXPECT_EQ(CheckQuarter(2).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace semmap
