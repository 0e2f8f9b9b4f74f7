#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "slam/place/vocabulary.h"
#include "tests/unit/cli/cli_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

class TrainVocabulary : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    std::filesystem::create_directories(Path("images/more"));
    std::filesystem::create_directories(Path("held_out"));
    for (int i = 0; i < 4; ++i) WriteNoise("images/a" + std::to_string(i) + ".png", i);
    for (int i = 0; i < 4; ++i) WriteNoise("images/more/b" + std::to_string(i) + ".jpg", 10 + i);
    WriteNoise("held_out/a1.jpg", 1);
  }

  void WriteNoise(const std::string& name, int seed) const {
    cv::Mat image(160, 200, CV_8UC1);
    cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 256);
    cv::imwrite(Path(name), image);
  }

  Outcome Train(const std::vector<std::string>& more, const std::string& output = "out.vocabulary") const {
    std::vector<std::string> arguments = {"train-vocabulary", "--output", Path(output), "--branching", "4",
                                          "--levels",         "3",        "--features", "200"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
};

TEST_F(TrainVocabulary, WritesAVocabularyOfAllImagesBelow) {
  const Outcome outcome = Train({"--images", Path("images")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto vocabulary = Vocabulary::Load(Path("out.vocabulary"));
  ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
  EXPECT_EQ((*vocabulary)->view().training_images, 8U);
  EXPECT_GT((*vocabulary)->words(), 20U);
  EXPECT_THAT(outcome.out, HasSubstr("from 8 images"));
  EXPECT_THAT(outcome.err, HasSubstr("level 3"));
}

TEST_F(TrainVocabulary, SameSeedSameBytes) {
  ASSERT_EQ(Train({"--images", Path("images")}, "one").exit_code, 0);
  ASSERT_EQ(Train({"--images", Path("images")}, "two").exit_code, 0);
  ASSERT_EQ(Train({"--images", Path("images"), "--seed", "2"}, "other").exit_code, 0);
  EXPECT_EQ(ReadText("one"), ReadText("two"));
  EXPECT_NE(ReadText("one"), ReadText("other"));
}

TEST_F(TrainVocabulary, TakesEveryNthAndLeavesOutWhatIsHeldOut) {
  EXPECT_THAT(Train({"--images", Path("images") + "@2"}).out, HasSubstr("from 4 images"));
  EXPECT_THAT(Train({"--images", Path("images"), "--hold-out", Path("held_out")}).out,
              HasSubstr("from 7 images"));
}

TEST_F(TrainVocabulary, SkipsWhatCannotBeRead) {
  WriteText("images/broken.png", "no image");
  const Outcome outcome = Train({"--images", Path("images")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("from 8 images"));
  EXPECT_THAT(outcome.err, HasSubstr("broken.png"));
}

TEST_F(TrainVocabulary, MissingAndEmptyFoldersFail) {
  EXPECT_EQ(Train({"--images", Path("nowhere")}).exit_code, 1);
  std::filesystem::create_directories(Path("empty"));
  const Outcome outcome = Train({"--images", Path("empty")});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no images"));
}

TEST_F(TrainVocabulary, WrongOptionsAreUsageErrors) {
  EXPECT_EQ(Train({}).exit_code, 2);
  EXPECT_EQ(Train({"--images", Path("images") + "@0"}).exit_code, 2);
  EXPECT_EQ(Train({"--images", Path("images"), "--direct-level", "7"}).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(Path("out.vocabulary")));
}

}  // namespace
}  // namespace semmap::client
