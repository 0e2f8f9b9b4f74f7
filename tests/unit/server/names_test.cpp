#include "server/names.h"

#include <gtest/gtest.h>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

TEST(Names, ParsesWhatItMakes) {
  EXPECT_EQ(*ParseMapName("map", MapName("town_2.a-b")), "town_2.a-b");
  EXPECT_EQ(*ParseSessionName("name", SessionName("7f")), "7f");
}

TEST(Names, RefusesWhatIsNoName) {
  for (const char* name :
       {"", "town", "maps/", "maps/-a", "maps/a/b", "maps/a b", "maps/\xc3\xa4", "sessions/town"}) {
    EXPECT_EQ(ReasonOf(ParseMapName("map", name).status()), v1::ERROR_REASON_NAME_INVALID) << name;
  }
  EXPECT_FALSE(ParseMapName("map", "maps/" + std::string(64, 'a')).ok());
  EXPECT_TRUE(ParseMapName("map", "maps/" + std::string(63, 'a')).ok());
}

TEST(Names, TextForLogsIsShortAndPrintable) {
  EXPECT_TRUE(ValidateText("agent", "semmap drive 0.1", 128).ok());
  EXPECT_TRUE(ValidateText("agent", "", 128).ok());
  EXPECT_FALSE(ValidateText("agent", "two\nlines", 128).ok());
  EXPECT_FALSE(ValidateText("agent", std::string(129, 'a'), 128).ok());
}

}  // namespace
}  // namespace semmap::server
