#include "server/artifacts.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "absl/strings/escaping.h"
#include "server/error_reasons.h"
#include "server/output_file.h"
#include "temporary_store.h"

namespace semmap::server {
namespace {

constexpr int64_t kMiB = 1 << 20;

class ArtifactsTest : public testing::Test {
 protected:
  absl::StatusOr<Artifact> Make(size_t bytes) {
    auto file = artifacts_.Begin();
    if (!file.ok()) return file.status();
    OutputFile output(file->get());
    if (absl::Status status = output.Append(std::string(bytes, 'a')); !status.ok()) return status;
    if (absl::Status status = output.Close(); !status.ok()) return status;
    return artifacts_.Publish(*std::move(file));
  }
  size_t Files() const {
    size_t count = 0;
    for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator(path_)) ++count;
    return count;
  }

  TemporaryDirectory directory_;
  const std::string path_ = directory_.path() + "/artifacts";
  TimestampNs now_ = 1000;
  Artifacts artifacts_{path_, 2 * kMiB, absl::Nanoseconds(500), [this] { return now_; }};
};

TEST_F(ArtifactsTest, AreFoundWithSizeAndChecksum) {
  const auto made = Make(1'000'000);
  ASSERT_TRUE(made.ok()) << made.status();
  const auto found = artifacts_.Find(made->id);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->size_bytes, 1'000'000);
  EXPECT_EQ(absl::BytesToHexString(found->sha256),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(found->expires_at, 1500);
  EXPECT_EQ(std::filesystem::file_size(found->path), 1'000'000U);
}

TEST_F(ArtifactsTest, GoWhenTheirTimeIsOver) {
  const auto made = Make(10);
  now_ = 1499;
  EXPECT_TRUE(artifacts_.Find(made->id).ok());
  now_ = 1500;
  EXPECT_EQ(ReasonOf(artifacts_.Find(made->id).status()), v1::ERROR_REASON_ARTIFACT_NOT_FOUND);
  EXPECT_EQ(Files(), 0U);
}

TEST_F(ArtifactsTest, TogetherTakeABoundedNumberOfBytes) {
  const auto first = Make(kMiB + 1);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(ReasonOf(Make(kMiB).status()), v1::ERROR_REASON_FILES_TOO_LARGE);
  EXPECT_EQ(Files(), 1U) << "a file that failed is still there";
  // To the last byte.
  EXPECT_TRUE(Make(kMiB - 1).ok());
  EXPECT_EQ(ReasonOf(Make(1).status()), v1::ERROR_REASON_FILES_TOO_LARGE);
  artifacts_.Remove(first->id);
  EXPECT_TRUE(Make(kMiB + 1).ok());
}

TEST_F(ArtifactsTest, AFileThatOthersWriteIsMeasured) {
  auto file = artifacts_.Begin();
  ASSERT_TRUE(file.ok());
  EXPECT_TRUE((*file)->GrowTo(kMiB).ok());
  std::ofstream((*file)->path()) << std::string(3 * kMiB, 'x');
  EXPECT_EQ(ReasonOf(artifacts_.Publish(*std::move(file)).status()), v1::ERROR_REASON_FILES_TOO_LARGE);
  EXPECT_EQ(Files(), 0U);
  EXPECT_TRUE(Make(2 * kMiB).ok()) << "its bytes were not given back";
}

TEST_F(ArtifactsTest, WhatAnEarlierRunLeftIsCleared) {
  std::filesystem::create_directories(path_);
  std::ofstream(path_ + "/0123.artifact") << "old";
  std::ofstream(path_ + "/notes.txt") << "somebody else's";
  ASSERT_TRUE(Make(1).ok());
  EXPECT_FALSE(std::filesystem::exists(path_ + "/0123.artifact"));
  EXPECT_TRUE(std::filesystem::exists(path_ + "/notes.txt"));
}

TEST(Artifacts, ADirectoryThatCannotBeMade) {
  Artifacts artifacts("/proc/artifacts", kMiB, absl::Seconds(1), [] { return TimestampNs{0}; });
  EXPECT_EQ(ReasonOf(artifacts.Begin().status()), v1::ERROR_REASON_STORE_UNAVAILABLE);
}

TEST_F(ArtifactsTest, TheBeginningCanBeWrittenOver) {
  auto file = artifacts_.Begin();
  OutputFile output(file->get());
  ASSERT_TRUE(output.Append("headrest").ok());
  ASSERT_TRUE(output.ReplaceBeginning("HEAD").ok());
  ASSERT_TRUE(output.Append("!").ok());
  ASSERT_TRUE(output.Close().ok());
  std::ifstream stream((*file)->path());
  std::string text;
  std::getline(stream, text);
  EXPECT_EQ(text, "HEADrest!");
}

}  // namespace
}  // namespace semmap::server
