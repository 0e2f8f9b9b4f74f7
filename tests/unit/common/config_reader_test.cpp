#include "slam/common/config_reader.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace semmap {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

struct InnerConfig {
  int levels = 8;
  double scale = 1.2;

  void Read(ConfigReader& reader) {
    reader.Number("levels", &levels, 1, 12);
    reader.Number("scale", &scale, 1.01, 2.0);
  }
};

struct OuterConfig {
  int count = 5;
  int64_t bytes = 1 << 20;
  double rate = 10;
  bool enabled = true;
  std::string name = "default";
  std::string mode = "fast";
  std::vector<double> list = {1, 2};
  std::vector<std::string> names = {"a"};
  InnerConfig inner;

  void Read(ConfigReader& reader) {
    reader.Number("count", &count, 0, 100);
    reader.Number("bytes", &bytes, 0, int64_t{1} << 40);
    reader.Number("rate", &rate, 0.0, 1000.0);
    reader.Flag("enabled", &enabled);
    reader.Text("name", &name);
    reader.Choice("mode", &mode, {"fast", "exact"});
    reader.NumberList("list", &list, 3);
    reader.TextList("names", &names, 2);
    reader.Section("inner", &inner);
  }
};

absl::Status ReadText(const std::string& text, OuterConfig* config) {
  absl::StatusOr<ConfigReader> reader = ConfigReader::FromText(text, "test.yaml");
  if (!reader.ok()) return reader.status();
  config->Read(*reader);
  return reader->Finish();
}

std::string MessageOf(const std::string& text) {
  OuterConfig config;
  const absl::Status status = ReadText(text, &config);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
  return std::string(status.message());
}

TEST(ConfigReader, ReadsEveryKind) {
  OuterConfig config;
  const absl::Status status = ReadText(
      "count: 7\n"
      "bytes: 5000000000\n"
      "rate: 2.5e1\n"
      "enabled: false\n"
      "name: 'a name'\n"
      "mode: exact\n"
      "list: [3, 4.5]\n"
      "names: [b, 7]\n"
      "inner:\n"
      "  levels: 4\n"
      "  scale: 1.5\n",
      &config);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(config.count, 7);
  EXPECT_EQ(config.bytes, 5000000000);
  EXPECT_EQ(config.rate, 25);
  EXPECT_FALSE(config.enabled);
  EXPECT_EQ(config.name, "a name");
  EXPECT_EQ(config.mode, "exact");
  EXPECT_THAT(config.list, ElementsAre(3, 4.5));
  EXPECT_THAT(config.names, ElementsAre("b", "7"));
  EXPECT_EQ(config.inner.levels, 4);
  EXPECT_EQ(config.inner.scale, 1.5);
}

TEST(ConfigReader, AbsentKeysKeepTheirDefaults) {
  for (const char* text : {"", "{}", "# only a comment\n", "count: 5\n", "inner:\n"}) {
    OuterConfig config;
    const absl::Status status = ReadText(text, &config);
    ASSERT_TRUE(status.ok()) << text << ": " << status.message();
    EXPECT_EQ(config.count, 5);
    EXPECT_EQ(config.name, "default");
    EXPECT_EQ(config.inner.levels, 8);
    EXPECT_THAT(config.list, ElementsAre(1, 2));
  }
}

TEST(ConfigReader, BoundsAreInclusive) {
  OuterConfig config;
  EXPECT_TRUE(ReadText("count: 0\nrate: 1000\ninner: {levels: 12}", &config).ok());
  EXPECT_EQ(config.inner.levels, 12);
  EXPECT_THAT(MessageOf("count: -1"), HasSubstr("test.yaml:1: count is -1, must be between 0 and 100"));
  EXPECT_THAT(MessageOf("count: 101"), HasSubstr("count"));
  EXPECT_THAT(MessageOf("rate: 1000.5"), HasSubstr("rate"));
  EXPECT_THAT(MessageOf("bytes: -5"), HasSubstr("bytes"));
}

TEST(ConfigReader, RefusedValuesLeaveTheDefault) {
  OuterConfig config;
  EXPECT_FALSE(ReadText("count: 500\nmode: slow\nenabled: perhaps\nlist: [1, x]", &config).ok());
  EXPECT_EQ(config.count, 5);
  EXPECT_EQ(config.mode, "fast");
  EXPECT_TRUE(config.enabled);
  EXPECT_THAT(config.list, ElementsAre(1, 2));
}

TEST(ConfigReader, NotANumberAndInfinityAreOutOfBounds) {
  EXPECT_THAT(MessageOf("rate: .nan"), HasSubstr("rate"));
  EXPECT_THAT(MessageOf("rate: .inf"), HasSubstr("rate"));
  EXPECT_THAT(MessageOf("list: [1, .nan]"), HasSubstr("list"));
  EXPECT_THAT(MessageOf("inner:\n  scale: .NaN"), HasSubstr("test.yaml:2: inner.scale"));
}

TEST(ConfigReader, WrongTypes) {
  EXPECT_THAT(MessageOf("count: many"), HasSubstr("count"));
  EXPECT_THAT(MessageOf("count: 2.5"), HasSubstr("count"));
  EXPECT_THAT(MessageOf("count: [1]"), HasSubstr("count"));
  EXPECT_THAT(MessageOf("count: 99999999999999"), HasSubstr("count"));
  EXPECT_THAT(MessageOf("count:"), HasSubstr("count"));
  EXPECT_THAT(MessageOf("enabled: 3"), HasSubstr("enabled"));
  EXPECT_THAT(MessageOf("name: [a, b]"), HasSubstr("name"));
  EXPECT_THAT(MessageOf("list: 4"), HasSubstr("list"));
  EXPECT_THAT(MessageOf("names: b"), HasSubstr("names"));
  EXPECT_THAT(MessageOf("names: [[b]]"), HasSubstr("names"));
  EXPECT_THAT(MessageOf("names: [a, b, c]"), HasSubstr("at most 2"));
  EXPECT_THAT(MessageOf("list: [1, [2]]"), HasSubstr("list"));
  EXPECT_THAT(MessageOf("inner: 4"), HasSubstr("inner is not a mapping"));
}

TEST(ConfigReader, ListsAreBounded) {
  OuterConfig config;
  EXPECT_TRUE(ReadText("list: [1, 2, 3]", &config).ok());
  EXPECT_TRUE(ReadText("list: []", &config).ok());
  EXPECT_TRUE(config.list.empty());
  EXPECT_THAT(MessageOf("list: [1, 2, 3, 4]"), HasSubstr("at most 3"));
}

TEST(ConfigReader, ChoicesAreNamed) {
  EXPECT_THAT(MessageOf("mode: slow"), HasSubstr("mode is 'slow', must be one of fast, exact"));
}

TEST(ConfigReader, UnknownKeysAreNamedWithLineAndSection) {
  EXPECT_THAT(MessageOf("count: 1\ncuont: 2\n"), HasSubstr("test.yaml:2: cuont is not a known key"));
  EXPECT_THAT(MessageOf("count: 1\ninner:\n  levels: 3\n  level: 3\n"),
              HasSubstr("test.yaml:4: inner.level is not a known key"));
}

TEST(ConfigReader, EveryComplaintIsListedWithItsLine) {
  const std::string message = MessageOf("count: 900\nrate: 5\nmode: slow\ninner:\n  levels: 0\nodd: 1\n");
  EXPECT_THAT(message, HasSubstr("test.yaml:1: count"));
  EXPECT_THAT(message, HasSubstr("test.yaml:3: mode"));
  EXPECT_THAT(message, HasSubstr("test.yaml:5: inner.levels"));
  EXPECT_THAT(message, HasSubstr("test.yaml:6: odd"));
  EXPECT_THAT(message, Not(HasSubstr("rate")));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 3);
}

TEST(ConfigReader, BrokenYamlNamesTheLine) {
  const auto reader = ConfigReader::FromText("count: 1\nname: [a, b\nrate: 3\n", "broken.yaml");
  EXPECT_EQ(reader.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(reader.status().message()), HasSubstr("broken.yaml:"));
  EXPECT_FALSE(ConfigReader::FromText("- a\n- list\n", "list.yaml").ok());
  EXPECT_FALSE(ConfigReader::FromText("just words", "words.yaml").ok());
}

TEST(ConfigReader, IgnoredAndAskedForKeysAreKnown) {
  absl::StatusOr<ConfigReader> reader = ConfigReader::FromText("server: {port: 1}\ncount: 3\n", "test.yaml");
  ASSERT_TRUE(reader.ok());
  EXPECT_TRUE(reader->Has("server"));
  EXPECT_FALSE(reader->Has("client"));
  reader->Ignore("server");
  OuterConfig config;
  config.Read(*reader);
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(config.count, 3);
}

TEST(ConfigReader, CallersMayComplain) {
  absl::StatusOr<ConfigReader> reader = ConfigReader::FromText("\ncount: 3\n", "test.yaml");
  ASSERT_TRUE(reader.ok());
  OuterConfig config;
  config.Read(*reader);
  reader->Complain("count", "must be even");
  reader->Complain("rate", "must be above count");
  const absl::Status status = reader->Finish();
  EXPECT_THAT(std::string(status.message()), HasSubstr("test.yaml:2: count must be even"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("rate must be above count"));
}

TEST(ConfigReader, FilesAreReadOrNotFound) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "config_reader_test.yaml";
  std::ofstream(path) << "count: 42\nunknown: 1\n";
  absl::StatusOr<ConfigReader> reader = ConfigReader::FromFile(path.string());
  ASSERT_TRUE(reader.ok());
  OuterConfig config;
  config.Read(*reader);
  EXPECT_EQ(config.count, 42);
  EXPECT_THAT(std::string(reader->Finish().message()), HasSubstr(path.string() + ":2: unknown"));
  std::filesystem::remove(path);
  EXPECT_EQ(ConfigReader::FromFile(path.string()).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace semmap
