#include "slam/semantics/segmentation_config.h"

#include <gtest/gtest.h>

#include "slam/common/config_reader.h"

namespace semmap {
namespace {

absl::StatusOr<SegmentationConfig> ConfigOf(const std::string& text) {
  auto reader = ConfigReader::FromText(text, "test");
  if (!reader.ok()) return reader.status();
  SegmentationConfig config;
  config.Read(*reader);
  const absl::Status status = reader->Finish();
  if (!status.ok()) return status;
  return config;
}

TEST(SegmentationConfig, ReadsModes) {
  EXPECT_EQ(ConfigOf("mode: off")->mode, SegmentationMode::kOff);
  EXPECT_EQ(ConfigOf("mode: every_frame")->mode, SegmentationMode::kEveryFrame);
  EXPECT_EQ(ConfigOf("mode: keyframes")->mode, SegmentationMode::kKeyFrames);
  EXPECT_FALSE(ConfigOf("mode: sometimes").ok());
  EXPECT_EQ(ConfigOf("live_mode: off")->live_mode, SegmentationMode::kOff);
  EXPECT_EQ(ConfigOf("mode: every_frame")->live_mode, SegmentationMode::kKeyFrames);
}

TEST(SegmentationConfig, NoLimitMeansThatFramesWait) {
  EXPECT_EQ(ConfigOf("max_wait_ms: 0")->max_wait(), absl::InfiniteDuration());
  EXPECT_EQ(ConfigOf("max_wait_ms: 80")->max_wait(), absl::Milliseconds(80));
  EXPECT_FALSE(ConfigOf("max_wait_ms: -1").ok());
}

}  // namespace
}  // namespace semmap
