#include "client/cli/eval_segmentation.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "cli_test_util.h"
#include "tests/support/tiny_network/tiny_network.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

// Images that are red on the left and blue on the right, of which the labels say Road and Sky.
class EvalSegmentationTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    model_ = WriteTinyNetwork(root_.string(), "tiny", kColourNetwork, "[6, 9, 13]");
    std::filesystem::create_directory(Path("images"));
    std::filesystem::create_directory(Path("labels"));
    for (const char* name : {"a", "b"}) WritePair(name, cv::Scalar(0, 0, 255));
  }

  void WritePair(const std::string& name, const cv::Scalar& left) const {
    const cv::Size size(128, 96);
    cv::Mat image(size, CV_8UC3, cv::Scalar(255, 0, 0));
    image.colRange(0, 64).setTo(left);
    cv::Mat label(size, CV_8UC1, cv::Scalar(13));
    label.colRange(0, 64).setTo(7);
    label.rowRange(0, 10).setTo(255);
    cv::imwrite(Path("images/" + name + ".png"), image);
    cv::imwrite(Path("labels/" + name + ".png"), label);
  }

  Outcome Eval(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"eval",     "segmentation", "--model",  model_,
                                          "--images", Path("images"), "--labels", Path("labels")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  std::string model_;
};

TEST_F(EvalSegmentationTest, PrintsTable1) {
  const Outcome result = Eval({"--merge", "camvid11"});
  EXPECT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Unlabeled          SKIP      SKIP"));
  EXPECT_THAT(result.out, HasSubstr("Building        MISSING   MISSING"));
  // RoadLine counts as Road.
  EXPECT_THAT(result.out, HasSubstr("Road            100.00%   100.00%"));
  EXPECT_THAT(result.out, HasSubstr("2 images, mean IoU over 2 classes present 1.0000"));
}

TEST_F(EvalSegmentationTest, JsonOfAListWithoutMerges) {
  WritePair("c", cv::Scalar(0, 255, 0));
  const std::string list = WriteText("val.txt", "images/a.png\nb\n");
  const Outcome result = Eval({"--list", list, "--json"});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  const nlohmann::json report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["images"], 2);
  EXPECT_EQ(report["pixels"], 2 * 128 * 86);
  EXPECT_DOUBLE_EQ(report["mean_iou"], 0.5);
  EXPECT_EQ(report["classes"][7]["iou"], 0.0);
  EXPECT_EQ(report["classes"][13]["accuracy"], 1.0);
  EXPECT_EQ(report["classes"][6]["iou"], "MISSING");
}

TEST_F(EvalSegmentationTest, SaysWhatIsMissing) {
  Outcome result = Eval({"--list", WriteText("val.txt", "nowhere\n")});
  EXPECT_EQ(result.exit_code, kExitFailed);
  EXPECT_THAT(result.err, HasSubstr("nowhere has no image or no label"));
  model_ = Path("other.yaml");
  result = Eval({});
  EXPECT_EQ(result.exit_code, kExitFailed);
  EXPECT_THAT(result.err, HasSubstr("other.yaml"));
}

}  // namespace
}  // namespace semmap::client
