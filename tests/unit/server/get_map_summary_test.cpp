#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

using GetMapSummaryTest = HandlerTest;

TEST_F(GetMapSummaryTest, CountsAndMeasures) {
  MakeMap("town", "s1", 12);
  v1::GetMapSummaryRequest request;
  request.set_name("maps/town");
  const auto summary = GetMapSummary(context_, request);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->frame_count(), 12);
  EXPECT_NEAR(summary->trajectory_length_m(), 11, 1e-9);
  EXPECT_EQ(summary->session_count(), 1);
  EXPECT_EQ(summary->keyframe_extent().max().x(), 11);
  EXPECT_EQ(summary->point_extent().min().z(), 10);
  ASSERT_EQ(summary->classes_size(), 2);
  EXPECT_EQ(summary->classes(0).display_name(), "Building");
  EXPECT_EQ(summary->classes(0).points(), 1);
  EXPECT_EQ(summary->classes(1).display_name(), "Vehicles");
  EXPECT_EQ(summary->classes(1).points(), 2);
}

TEST_F(GetMapSummaryTest, NoSuchMap) {
  v1::GetMapSummaryRequest request;
  request.set_name("maps/nowhere");
  EXPECT_EQ(ReasonOf(GetMapSummary(context_, request).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
}

}  // namespace
}  // namespace semmap::server
