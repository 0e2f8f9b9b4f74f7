#include "client/cli/point_filter_options.h"

#include <gtest/gtest.h>

#include "client/cli/console.h"

namespace semmap::client {
namespace {

absl::StatusOr<v1::MapPointFilter> Parse(const std::string& line) {
  CLI::App app;
  PointFilterOptions options;
  AddPointFilterOptions(app, &options);
  app.parse(line);
  return FilterOf(options);
}

TEST(PointFilterOptions, BecomeAFilter) {
  const auto filter = Parse(
      "--class road --class 1 --min-observations 3 --min-confidence 0.5 --seen-from 10 --seen-until 20 "
      "--active "
      "--sphere 1 2 3 4");
  ASSERT_TRUE(filter.ok()) << filter.status();
  EXPECT_EQ(std::vector<uint32_t>(filter->semantic_classes().begin(), filter->semantic_classes().end()),
            (std::vector<uint32_t>{7, 1}));
  EXPECT_EQ(filter->min_observations(), 3);
  EXPECT_EQ(filter->min_class_confidence(), 0.5);
  EXPECT_EQ(filter->seen().start_ns(), 10);
  EXPECT_EQ(filter->seen().end_ns(), 20);
  EXPECT_TRUE(filter->active_only());
  EXPECT_EQ(filter->area().sphere().center().y(), 2);
  EXPECT_EQ(filter->area().sphere().radius_m(), 4);
}

TEST(PointFilterOptions, NoneGivenIsNoCondition) {
  const auto filter = Parse("");
  ASSERT_TRUE(filter.ok());
  EXPECT_EQ(filter->ByteSizeLong(), 0U) << filter->ShortDebugString();
}

TEST(PointFilterOptions, AClassThatThereIsNot) {
  EXPECT_EQ(ExitCodeOf(Parse("--class castle").status()), kExitUsage);
}

}  // namespace
}  // namespace semmap::client
