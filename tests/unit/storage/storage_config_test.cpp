#include "storage/storage_config.h"

#include "gtest/gtest.h"
#include "slam/common/config_reader.h"

namespace semmap::storage {
namespace {

absl::Status Read(const std::string& text, StorageConfig* config) {
  absl::StatusOr<ConfigReader> reader = ConfigReader::FromText(text, "test.yaml");
  if (!reader.ok()) return reader.status();
  config->Read(*reader);
  return reader->Finish();
}

TEST(StorageConfig, ReadsWhatIsThereAndKeepsTheRest) {
  StorageConfig config;
  ASSERT_TRUE(Read("uri: sqlite:///tmp/a.db\nsynchronous: full\ncache_mb: 64\n", &config).ok());
  EXPECT_EQ(config.uri, "sqlite:///tmp/a.db");
  EXPECT_EQ(config.synchronous, "full");
  EXPECT_EQ(config.cache_mb, 64);
  EXPECT_EQ(config.busy_timeout_ms, StorageConfig().busy_timeout_ms);
}

TEST(StorageConfig, RefusesValuesOutOfBounds) {
  for (const char* text :
       {"synchronous: off", "busy_timeout_ms: -1", "cache_mb: 0", "max_readers: 65", "cache: 3"}) {
    StorageConfig config;
    EXPECT_TRUE(absl::IsInvalidArgument(Read(text, &config))) << text;
  }
}

}  // namespace
}  // namespace semmap::storage
