#include "slam/semantics/torch/torch_segmenter.h"

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/support/tiny_network/tiny_network.h"

namespace semmap {
namespace {

constexpr const char* kColourClasses = "[7, 9, 13]";  // red, green, blue
const cv::Scalar kRed(20, 30, 220);
const cv::Scalar kGreen(20, 220, 30);
const cv::Scalar kBlue(220, 20, 30);

class TorchSegmenterTest : public testing::Test {
 protected:
  TorchSegmenterTest() : folder_(testing::TempDir() + "/torch_segmenter_XXXXXX") {
    EXPECT_NE(mkdtemp(folder_.data()), nullptr);
  }
  ~TorchSegmenterTest() override { std::filesystem::remove_all(folder_); }

  absl::StatusOr<std::unique_ptr<Segmenter>> LoadNetwork(const std::string& source,
                                                         const std::string& classes = kColourClasses) {
    return LoadTorchSegmenter(WriteTinyNetwork(folder_, "tiny", source, classes), 1);
  }

  void ExpectRefused(const std::string& source, const std::string& reason) {
    const absl::Status status = LoadNetwork(source).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_NE(std::string(status.message()).find(reason), std::string::npos) << status;
    EXPECT_NE(std::string(status.message()).find("tiny.pt"), std::string::npos) << status;
    // No call stacks of libtorch.
    EXPECT_EQ(std::string(status.message()).find('\n'), std::string::npos) << status;
  }

  std::string folder_;
};

// Left half one colour, right half another.
cv::Mat TwoColours(cv::Size size, const cv::Scalar& left, const cv::Scalar& right) {
  cv::Mat image(size, CV_8UC3, left);
  image.colRange(size.width / 2, size.width).setTo(right);
  return image;
}

TEST_F(TorchSegmenterTest, ColoursBecomeTheirClasses) {
  const auto segmenter = LoadNetwork(kColourNetwork);
  ASSERT_TRUE(segmenter.ok()) << segmenter.status();
  const cv::Mat image = TwoColours({640, 480}, kRed, kBlue);
  const auto segmented = (*segmenter)->Segment({&image, 1});
  ASSERT_TRUE(segmented.ok()) << segmented.status();
  ASSERT_EQ(segmented->size(), 1U);
  EXPECT_EQ(segmented->front().image(), image.size());
  EXPECT_EQ(segmented->front().grid(), cv::Size(64, 48));
  EXPECT_EQ(segmented->front().At(100, 100).semantic_class, 7);
  EXPECT_EQ(segmented->front().At(500, 100).semantic_class, 13);
  // softmax of 10 * (220, 30, 20) / 255
  EXPECT_NEAR(segmented->front().At(100, 100).confidence, 255, 2);
}

TEST_F(TorchSegmenterTest, ABatchGivesWhatItsImagesGiveAlone) {
  const auto segmenter = LoadNetwork(kColourNetwork);
  ASSERT_TRUE(segmenter.ok()) << segmenter.status();
  // Two sizes of the network, and one grey image.
  const std::vector<cv::Mat> images = {
      TwoColours({640, 480}, kRed, kBlue), TwoColours({320, 240}, kGreen, kRed),
      TwoColours({1241, 376}, kBlue, kGreen), cv::Mat(240, 320, CV_8UC1, cv::Scalar(9))};
  const auto together = (*segmenter)->Segment(images);
  ASSERT_TRUE(together.ok()) << together.status();
  ASSERT_EQ(together->size(), images.size());
  for (size_t i = 0; i < images.size(); ++i) {
    const auto alone = (*segmenter)->Segment({&images[i], 1});
    ASSERT_TRUE(alone.ok()) << alone.status();
    cv::Mat mask_alone;
    cv::Mat mask_together;
    alone->front().ToMasks(&mask_alone, nullptr);
    (*together)[i].ToMasks(&mask_together, nullptr);
    ASSERT_EQ(mask_together.size(), images[i].size());
    EXPECT_EQ(cv::norm(mask_alone, mask_together, cv::NORM_INF), 0) << i;
  }
  EXPECT_EQ((*together)[1].At(10, 10).semantic_class, 9);
  EXPECT_EQ((*together)[2].At(10, 10).semantic_class, 13);
}

TEST_F(TorchSegmenterTest, SeveralThreadsMayAsk) {
  const auto segmenter = LoadNetwork(kColourNetwork);
  ASSERT_TRUE(segmenter.ok()) << segmenter.status();
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&segmenter, i] {
      const cv::Mat image(96, 128, CV_8UC3, i == 0 ? kRed : i == 1 ? kGreen : kBlue);
      for (int run = 0; run < 20; ++run) {
        const auto segmented = (*segmenter)->Segment({&image, 1});
        ASSERT_TRUE(segmented.ok()) << segmented.status();
        EXPECT_EQ(segmented->front().At(60, 40).semantic_class, i == 0 ? 7 : i == 1 ? 9 : 13);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(TorchSegmenterTest, RefusesOtherPixels) {
  const auto segmenter = LoadNetwork(kColourNetwork);
  ASSERT_TRUE(segmenter.ok()) << segmenter.status();
  for (const cv::Mat& image : {cv::Mat(), cv::Mat(10, 10, CV_16UC1, cv::Scalar(0))}) {
    EXPECT_EQ((*segmenter)->Segment({&image, 1}).status().code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST_F(TorchSegmenterTest, MissingFilesAreNamed) {
  EXPECT_EQ(LoadTorchSegmenter(folder_ + "/none.yaml", 1).status().code(), absl::StatusCode::kNotFound);
  std::ofstream(folder_ + "/model.yaml") << "file: none.pt\n";
  const absl::Status status = LoadTorchSegmenter(folder_ + "/model.yaml", 1).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_NE(std::string(status.message()).find(folder_ + "/none.pt"), std::string::npos) << status;
}

TEST_F(TorchSegmenterTest, RefusesWhatIsNoTorchScript) {
  std::ofstream(folder_ + "/model.yaml") << "file: model.pt\n";
  std::ofstream(folder_ + "/model.pt") << "these are not the weights you are looking for";
  const absl::Status status = LoadTorchSegmenter(folder_ + "/model.yaml", 1).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(std::string(status.message()).find("TorchScript"), std::string::npos) << status;
  EXPECT_EQ(std::string(status.message()).find('\n'), std::string::npos) << status;
}

TEST_F(TorchSegmenterTest, RefusesNetworksThatDoSomethingElse) {
  ExpectRefused("def forward(self, x):\n    return x[:, :2]\n", "2 channels, its description 3 classes");
  ExpectRefused("def forward(self, x):\n    return torch.avg_pool2d(x, [8, 8])\n", "16 x 12 cells");
  ExpectRefused("def forward(self, x):\n    return x[:, :, 1:]\n", "128 x 95 cells");
  ExpectRefused("def forward(self, x):\n    return x[0]\n", "3 dimensions");
  ExpectRefused("def forward(self, x):\n    return [x]\n", "tensor");
  ExpectRefused("def forward(self, x):\n    return x / (x - x)\n", "not numbers");
  ExpectRefused("def forward(self, x):\n    return x.reshape([7, 3])\n", "");
  ExpectRefused("def forward(self, x, y):\n    return x + y\n", "");
}

TEST_F(TorchSegmenterTest, WhatAllSessionsShareIsLoadedUnlessOff) {
  SegmentationConfig config;
  config.model = WriteTinyNetwork(folder_, "tiny", kColourNetwork, kColourClasses);
  config.mode = SegmentationMode::kOff;
  EXPECT_EQ(LoadSegmentation(config).value(), nullptr);
  config.mode = SegmentationMode::kEveryFrame;
  const auto queue = LoadSegmentation(config);
  ASSERT_TRUE(queue.ok()) << queue.status();
  const auto segmentation = (*queue)->Submit(TwoColours({64, 48}, kGreen, kGreen)).Wait(absl::Seconds(10));
  ASSERT_NE(segmentation, nullptr);
  EXPECT_EQ(segmentation->At(3, 3).semantic_class, 9);
}

}  // namespace
}  // namespace semmap
