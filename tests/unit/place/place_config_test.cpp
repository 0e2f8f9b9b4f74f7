#include "slam/place/place_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slam/common/config_reader.h"

namespace semmap {
namespace {

TEST(PlaceConfig, ReadsItsFields) {
  auto reader = ConfigReader::FromText(
      "vocabulary: some.vocabulary\nquery: {max_postings: 5000, max_candidates: 7}", "test");
  PlaceConfig config;
  config.Read(*reader);
  ASSERT_TRUE(reader->Finish().ok());
  EXPECT_EQ(config.vocabulary, "some.vocabulary");
  EXPECT_EQ(config.query.max_postings, 5000);
  EXPECT_EQ(config.query.max_candidates, 7);
}

TEST(PlaceConfig, RefusesWhatIsOutOfBounds) {
  auto reader = ConfigReader::FromText("query: {max_postings: 10, max_candidates: 0}", "test");
  PlaceConfig config;
  config.Read(*reader);
  const std::string complaints(reader->Finish().message());
  EXPECT_THAT(complaints, ::testing::HasSubstr("query.max_postings"));
  EXPECT_THAT(complaints, ::testing::HasSubstr("query.max_candidates"));
}

}  // namespace
}  // namespace semmap
