#include "tests/bench/slam_bench_config.h"

#include <fstream>

#include <gmock/gmock.h>

namespace semmap::bench {
namespace {

using ::testing::HasSubstr;

TEST(SlamBenchConfig, SettingsGoBeforeTheFile) {
  const std::string path = ::testing::TempDir() + "slam_bench_config_test.yaml";
  std::ofstream(path) << "slam:\n  seed: 5\n  orb: {features: 700}\n";
  const auto config = ReadSlamConfig(path, {"slam.orb.features=900", "slam.semantics.inactive_classes=[Sky]",
                                            "slam.semantics.penalty=0.25"});
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->seed, 5);
  EXPECT_EQ(config->orb.features, 900);
  EXPECT_EQ(config->semantics.inactive_classes, std::vector<std::string>{"Sky"});
  EXPECT_EQ(config->semantics.penalty, 0.25);
  EXPECT_EQ(ReadSlamConfig(path, {})->orb.features, 700);
  EXPECT_EQ(ReadSlamConfig("", {})->orb.features, SlamConfig().orb.features);
}

TEST(SlamBenchConfig, RefusesWhatIsNoSetting) {
  for (const char* setting : {"slam.orb.features", "slam.orb.features=x", "slam.orb.feature=900", "=3",
                              "slam.seed.deeper=1", "slam.orb.features=[", "slam.semantics.penalty=-1"}) {
    const auto config = ReadSlamConfig("", {"slam.seed=3", setting});
    EXPECT_EQ(config.status().code(), absl::StatusCode::kInvalidArgument) << setting;
  }
  EXPECT_THAT(std::string(ReadSlamConfig("", {"slam.speed=1"}).status().message()), HasSubstr("slam.speed"));
}

}  // namespace
}  // namespace semmap::bench
