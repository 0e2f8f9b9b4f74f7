#include "slam/place/vocabulary_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/unit/place/place_test_util.h"

namespace semmap {
namespace {

using ::testing::HasSubstr;
using testing::RandomTree;

class VocabularyFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::testing::TempDir() + ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    path_ = folder_ + "/some.vocabulary";
    bytes_ = EncodeVocabulary(tree_.View());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  absl::Status LoadBytes(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return Vocabulary::Load(path_).status();
  }

  const VocabularyTree tree_ = RandomTree(9, 7);
  std::string folder_;
  std::string path_;
  std::string bytes_;
};

TEST_F(VocabularyFile, ComesBackAsItWas) {
  ASSERT_TRUE(WriteVocabulary(path_, tree_.View()).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
  const auto loaded = Vocabulary::Load(path_);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  const VocabularyView& view = (*loaded)->view();
  EXPECT_EQ(view.branching, tree_.branching);
  EXPECT_EQ(view.levels, tree_.levels);
  EXPECT_EQ(view.direct_level, tree_.direct_level);
  EXPECT_EQ(view.training_images, tree_.training_images);
  EXPECT_TRUE(std::equal(view.nodes.begin(), view.nodes.end(), tree_.nodes.begin(), tree_.nodes.end()));
  EXPECT_TRUE(
      std::equal(view.centres.begin(), view.centres.end(), tree_.centres.begin(), tree_.centres.end()));
  EXPECT_TRUE(std::equal(view.idf.begin(), view.idf.end(), tree_.idf.begin(), tree_.idf.end()));
  EXPECT_EQ((*loaded)->id(), Vocabulary::FromTree(tree_).value()->id());
}

TEST_F(VocabularyFile, OutlivesItsReplacement) {
  ASSERT_TRUE(WriteVocabulary(path_, tree_.View()).ok());
  const auto loaded = Vocabulary::Load(path_).value();
  const VocabularyTree other = RandomTree(3, 8);
  ASSERT_TRUE(WriteVocabulary(path_, other.View()).ok());
  EXPECT_EQ(loaded->view().centres[5], tree_.centres[5]);
  EXPECT_EQ(Vocabulary::Load(path_).value()->words(), 9U);
}

TEST_F(VocabularyFile, MissingFileIsNotFoundAndNamed) {
  const absl::Status status = Vocabulary::Load(path_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr(path_));
}

TEST_F(VocabularyFile, FolderAndEmptyFileAreInvalid) {
  EXPECT_EQ(Vocabulary::Load(folder_).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(LoadBytes("").code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(VocabularyFile, AnotherKindOfFileIsInvalid) {
  const absl::Status status = LoadBytes("\x89PNG" + bytes_.substr(4));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("not a vocabulary"));
}

TEST_F(VocabularyFile, AnotherVersionIsNamed) {
  bytes_[8] = 2;
  const absl::Status status = LoadBytes(bytes_);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("version 2"));
}

TEST_F(VocabularyFile, EveryTruncationIsDataLoss) {
  for (const size_t size :
       {size_t{1}, size_t{63}, size_t{64}, size_t{100}, bytes_.size() / 2, bytes_.size() - 1}) {
    EXPECT_EQ(LoadBytes(bytes_.substr(0, size)).code(), absl::StatusCode::kDataLoss) << size;
  }
  EXPECT_EQ(LoadBytes(bytes_ + "x").code(), absl::StatusCode::kDataLoss);
}

TEST_F(VocabularyFile, EveryChangedByteIsNoticed) {
  for (size_t i = 0; i < bytes_.size(); ++i) {
    std::string changed = bytes_;
    changed[i] = static_cast<char>(changed[i] ^ 0x10);
    alignas(32) static std::array<std::byte, 8192> aligned;
    ASSERT_LE(changed.size(), aligned.size());
    std::memcpy(aligned.data(), changed.data(), changed.size());
    EXPECT_FALSE(DecodeVocabulary(std::span(aligned).first(changed.size())).ok()) << i;
  }
}

// Trees whose checksum is right but which are no trees: a writer's bug must not become a reader's.
class BrokenTree : public ::testing::Test {
 protected:
  void ExpectRefused() { EXPECT_EQ(CheckVocabulary(tree_.View()).code(), absl::StatusCode::kDataLoss); }
  VocabularyTree tree_ = RandomTree(3, 9);
};

TEST_F(BrokenTree, WholeTreeIsFine) { EXPECT_TRUE(CheckVocabulary(tree_.View()).ok()); }

TEST_F(BrokenTree, NoNodes) {
  tree_ = {};
  ExpectRefused();
}

TEST_F(BrokenTree, Cycle) {
  tree_.nodes[2].first = 0;
  ExpectRefused();
}

TEST_F(BrokenTree, LinkBeyondTheEnd) {
  tree_.nodes[3].first = 11;
  ExpectRefused();
}

TEST_F(BrokenTree, WordBeyondTheEnd) {
  tree_.nodes.back().first = 9;
  ExpectRefused();
}

TEST_F(BrokenTree, TooManyChildren) {
  tree_.branching = 2;
  ExpectRefused();
}

TEST_F(BrokenTree, DeeperThanItSays) {
  tree_.levels = 1;
  ExpectRefused();
}

TEST_F(BrokenTree, NodesWithoutParent) {
  tree_.nodes.push_back({9, 0});
  tree_.centres.emplace_back();
  tree_.idf.push_back(1);
  ExpectRefused();
}

TEST_F(BrokenTree, WeightIsNotANumber) {
  tree_.idf[4] = std::numeric_limits<float>::quiet_NaN();
  ExpectRefused();
}

TEST_F(BrokenTree, DirectLevelBelowTheLeaves) {
  tree_.direct_level = 3;
  ExpectRefused();
}

}  // namespace
}  // namespace semmap
