#include "server/server_config.h"

#include <fstream>

#include <gtest/gtest.h>

#include "temporary_store.h"

namespace semmap::server {
namespace {

absl::StatusOr<Config> ConfigOf(const std::string& text) {
  const TemporaryDirectory directory;
  const std::string path = directory.path() + "/semmapd.yaml";
  std::ofstream(path) << text;
  return Config::FromFile(path);
}

TEST(ServerConfig, TheFilesOfTheRepositoryAreGood) {
  for (const char* name : {"semmapd.yaml", "semmapd-deterministic.yaml"}) {
    const auto config = Config::FromFile(std::string(SEMMAP_SOURCE_DIR) + "/config/" + name);
    EXPECT_TRUE(config.ok()) << config.status();
  }
  const auto config = Config::FromFile(std::string(SEMMAP_SOURCE_DIR) + "/config/semmapd-deterministic.yaml");
  EXPECT_TRUE(config->slam.deterministic);
}

// The documented file shows the defaults: what it says and what the code does must not part.
TEST(ServerConfig, TheDocumentedFileSaysTheDefaults) {
  const auto config = Config::FromFile(std::string(SEMMAP_SOURCE_DIR) + "/config/semmapd.yaml");
  ASSERT_TRUE(config.ok()) << config.status();
  const ServerConfig defaults;
  EXPECT_EQ(config->server.listen, defaults.listen);
  EXPECT_EQ(config->server.credit_window, defaults.credit_window);
  EXPECT_EQ(config->server.max_sessions, defaults.max_sessions);
  EXPECT_EQ(config->server.max_image_pixels, defaults.max_image_pixels);
  EXPECT_EQ(config->server.resume_timeout_s, defaults.resume_timeout_s);
  EXPECT_EQ(config->storage.keyframe_keypoints, storage::StorageConfig().keyframe_keypoints);
  EXPECT_EQ(config->slam.orb.features, SlamConfig().orb.features);
  const SlamConfig slam;
  EXPECT_EQ(config->slam.stereo.max_depth_in_baselines, slam.stereo.max_depth_in_baselines);
  EXPECT_EQ(config->slam.stereo.min_depths, slam.stereo.min_depths);
  EXPECT_EQ(config->slam.tracking.doubtful_inlier_share, slam.tracking.doubtful_inlier_share);
  EXPECT_EQ(config->slam.tracking.keyframe_ratio, slam.tracking.keyframe_ratio);
  EXPECT_EQ(config->slam.mapping.queue, slam.mapping.queue);
  EXPECT_EQ(config->slam.mapping.neighbours_to_triangulate, slam.mapping.neighbours_to_triangulate);
  EXPECT_EQ(config->slam.place.query.max_postings, slam.place.query.max_postings);
  EXPECT_EQ(config->slam.relocalization.limits.min_inliers, slam.relocalization.limits.min_inliers);
  EXPECT_EQ(config->slam.loop.consistency, slam.loop.consistency);
  EXPECT_EQ(config->slam.loop.full_iterations, slam.loop.full_iterations);
  EXPECT_EQ(config->slam.segmentation.mode, Config().slam.segmentation.mode);
  EXPECT_EQ(config->slam.segmentation.live_mode, slam.segmentation.live_mode);
  EXPECT_EQ(config->slam.segmentation.max_batch, slam.segmentation.max_batch);
  EXPECT_EQ(config->slam.segmentation.max_waiting, slam.segmentation.max_waiting);
  EXPECT_EQ(config->slam.segmentation.max_wait_ms, slam.segmentation.max_wait_ms);
}

TEST(ServerConfig, AServiceSegmentsKeyframesUnlessItIsToldNotTo) {
  EXPECT_EQ(ConfigOf("server:\n  max_sessions: 3\n")->slam.segmentation.mode, SegmentationMode::kKeyFrames);
  EXPECT_EQ(ConfigOf("slam:\n  segmentation:\n    mode: off\n")->slam.segmentation.mode,
            SegmentationMode::kOff);
}

TEST(ServerConfig, RefusesUnknownKeysAndBadValuesWithTheirLine) {
  const auto status = ConfigOf("server:\n  max_sessions: 0\n  max_session: 3\n").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(std::string(status.message()).find(":2: server.max_sessions"), std::string::npos) << status;
  EXPECT_NE(std::string(status.message()).find(":3: server.max_session "), std::string::npos) << status;
}

}  // namespace
}  // namespace semmap::server
