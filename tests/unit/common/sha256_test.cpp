#include "slam/common/sha256.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "absl/strings/escaping.h"

namespace semmap {
namespace {

// Examples of FIPS 180-4.
constexpr const char* kOfNothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr const char* kOfAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr const char* kOfAMillionA = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";

TEST(Sha256, MatchesThePublishedExamples) {
  EXPECT_EQ(absl::BytesToHexString(Sha256().Finish()), kOfNothing);
  Sha256 pieces;
  pieces.Update("a");
  pieces.Update("");
  pieces.Update("bc");
  EXPECT_EQ(absl::BytesToHexString(pieces.Finish()), kOfAbc);
}

TEST(Sha256, OfAFile) {
  const std::string path = testing::TempDir() + "/semmap_sha256_of_a_file";
  std::ofstream(path, std::ios::binary) << std::string(1'000'000, 'a');
  const auto digest = Sha256OfFile(path);
  ASSERT_TRUE(digest.ok()) << digest.status();
  EXPECT_EQ(absl::BytesToHexString(*digest), kOfAMillionA);
  std::filesystem::remove(path);
  EXPECT_TRUE(absl::IsNotFound(Sha256OfFile(path).status()));
}

}  // namespace
}  // namespace semmap
