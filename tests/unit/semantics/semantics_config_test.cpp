#include "slam/semantics/semantics_config.h"

#include <gtest/gtest.h>

#include "slam/common/config_reader.h"

namespace semmap {
namespace {

absl::Status ReadText(const std::string& text, SemanticsConfig* config) {
  auto reader = ConfigReader::FromText(text, "test.yaml");
  if (!reader.ok()) return reader.status();
  config->Read(*reader);
  return reader->Finish();
}

TEST(SemanticsConfigTest, DefaultsAreThePapers) {
  const SemanticsConfig config;
  EXPECT_TRUE(config.enabled);
  EXPECT_TRUE(config.votes);
  EXPECT_EQ(config.InactiveClasses(), ClassSet(kInactiveClasses));
  EXPECT_EQ(config.penalty, 0.5);
  EXPECT_FALSE(config.strict);
}

TEST(SemanticsConfigTest, EitherSwitchLeavesEveryPointActive) {
  for (const char* text : {"enabled: false", "filter_inactive: false", "inactive_classes: []"}) {
    SemanticsConfig config;
    ASSERT_TRUE(ReadText(text, &config).ok()) << text;
    EXPECT_TRUE(config.InactiveClasses().empty()) << text;
  }
}

TEST(SemanticsConfigTest, ReadsEveryKey) {
  SemanticsConfig config;
  const absl::Status status = ReadText(
      "enabled: true\nmin_confidence: 0.25\nsky_rim_px: 5\nclass_rim_px: 2\nvotes: false\nfilter_inactive: "
      "true\n"
      "inactive_classes: [sky, Vehicles]\npenalty: 1.5\nstrict: true\n",
      &config);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(config.min_confidence, 0.25);
  EXPECT_EQ(config.sky_rim_px, 5);
  EXPECT_EQ(config.class_rim_px, 2);
  EXPECT_FALSE(config.PointPolicy().majority);
  EXPECT_TRUE(config.InactiveClasses().Contains(13));
  EXPECT_TRUE(config.InactiveClasses().Contains(10));
  EXPECT_FALSE(config.InactiveClasses().Contains(4));
  EXPECT_EQ(config.penalty, 1.5);
  EXPECT_TRUE(config.strict);
}

TEST(SemanticsConfigTest, RefusesWhatIsNotAClassOrOutOfBounds) {
  SemanticsConfig config;
  for (const char* text :
       {"inactive_classes: [Car]", "inactive_classes: Sky", "penalty: -1", "min_confidence: 2"})
    EXPECT_EQ(ReadText(text, &config).code(), absl::StatusCode::kInvalidArgument) << text;
}

}  // namespace
}  // namespace semmap
