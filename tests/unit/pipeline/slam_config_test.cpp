#include "slam/pipeline/slam_config.h"

#include <fstream>

#include <gtest/gtest.h>

#include "slam/common/config_reader.h"

namespace semmap {
namespace {

absl::Status ReadText(const std::string& text, SlamConfig* config) {
  auto reader = ConfigReader::FromText(text, "test.yaml");
  if (!reader.ok()) return reader.status();
  reader->Section("slam", config);
  return reader->Finish();
}

TEST(SlamConfigTest, ReadsNestedValuesAndKeepsDefaults) {
  SlamConfig config;
  ASSERT_TRUE(ReadText("slam:\n  deterministic: true\n  orb:\n    features: 1200\n", &config).ok());
  EXPECT_TRUE(config.deterministic);
  EXPECT_EQ(config.orb.features, 1200);
  EXPECT_EQ(config.orb.levels, OrbConfig().levels);
}

TEST(SlamConfigTest, ComplaintsNameFileLineAndKey) {
  SlamConfig config;
  const absl::Status status = ReadText("slam:\n  mapping:\n    queue: 0\n  speed: 3\n", &config);
  ASSERT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("test.yaml:3: slam.mapping.queue"), std::string::npos) << status;
  EXPECT_NE(status.message().find("test.yaml:4: slam.speed"), std::string::npos) << status;
}

TEST(SlamConfigTest, IntervalsMustAgree) {
  SlamConfig config;
  EXPECT_FALSE(
      ReadText("slam:\n  tracking: {min_keyframe_interval_s: 2, max_keyframe_interval_s: 1}\n", &config)
          .ok());
}

TEST(SlamConfigTest, FileMayHoldOtherProgramsParts) {
  const std::string path = ::testing::TempDir() + "slam_config_test.yaml";
  std::ofstream(path) << "server:\n  anything: 1\nslam:\n  seed: 5\n";
  const auto config = SlamConfig::FromFile(path);
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->seed, 5);
  EXPECT_EQ(SlamConfig::FromFile("/no/such/file").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace semmap
