#include "server/page_token.h"

#include <gtest/gtest.h>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

TEST(PageToken, BringsTheCursorBack) {
  EXPECT_EQ(*ReadPageToken("list", MakePageToken("list", "maps/7")), "maps/7");
  EXPECT_EQ(*ReadPageToken("list", ""), "");
}

TEST(PageToken, RefusesWhatItDidNotMakeForThisRequest) {
  const std::string token = MakePageToken("list a", "7");
  EXPECT_EQ(ReasonOf(ReadPageToken("list b", token).status()), v1::ERROR_REASON_PAGE_TOKEN_INVALID);
  EXPECT_EQ(ReasonOf(ReadPageToken("list a", token + "A").status()), v1::ERROR_REASON_PAGE_TOKEN_INVALID);
  EXPECT_EQ(ReasonOf(ReadPageToken("list a", "7").status()), v1::ERROR_REASON_PAGE_TOKEN_INVALID);
  EXPECT_EQ(ReasonOf(ReadPageToken("list a", "!!").status()), v1::ERROR_REASON_PAGE_TOKEN_INVALID);
}

TEST(PageSize, HasADefaultAndABound) {
  EXPECT_EQ(*ReadPageSize(0, 100, 1000), 100);
  EXPECT_EQ(*ReadPageSize(7, 100, 1000), 7);
  EXPECT_EQ(*ReadPageSize(5000, 100, 1000), 1000);
  EXPECT_EQ(ReasonOf(ReadPageSize(-1, 100, 1000).status()), v1::ERROR_REASON_FIELD_INVALID);
}

}  // namespace
}  // namespace semmap::server
