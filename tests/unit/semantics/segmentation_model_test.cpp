#include "slam/semantics/segmentation_model.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace semmap {
namespace {

absl::StatusOr<SegmentationModel> ModelOf(const std::string& text) {
  const std::string path = testing::TempDir() + "/segmentation_model_test.yaml";
  std::ofstream(path) << text;
  auto model = SegmentationModel::FromFile(path);
  std::filesystem::remove(path);
  return model;
}

void ExpectRefused(const std::string& text, const std::string& reason) {
  const absl::Status status = ModelOf(text).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
  EXPECT_NE(std::string(status.message()).find(reason), std::string::npos) << status;
}

TEST(SegmentationModel, ReadsADescription) {
  const auto model = ModelOf(
      "file: street.pt\ninput_width: 640\ninput_height: 480\nmean: [0.1, 0.2, 0.3]\nstd: [1, 2, 3]\n"
      "classes: [7, 255, 13]\n");
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(std::filesystem::path(model->file).filename(), "street.pt");
  EXPECT_EQ(std::filesystem::path(model->file).parent_path(),
            std::filesystem::path(testing::TempDir() + "/").parent_path());
  EXPECT_EQ(model->input_width, 640);
  EXPECT_FLOAT_EQ(model->mean[2], 0.3F);
  EXPECT_FLOAT_EQ(model->std[1], 2.0F);
  EXPECT_EQ(*model->class_of_channel, (std::vector<uint8_t>{7, 255, 13}));
}

TEST(SegmentationModel, Carla23AreTheIdsInOrder) {
  const auto model = ModelOf("file: street.pt\nclasses: carla23\n");
  ASSERT_TRUE(model.ok()) << model.status();
  ASSERT_EQ(model->class_of_channel->size(), 23U);
  EXPECT_EQ(model->class_of_channel->at(13), 13);
}

TEST(SegmentationModel, RefusesWhatCannotBe) {
  ExpectRefused("classes: carla23\n", "file");
  ExpectRefused("file: a.pt\ninput_width: 500\n", "multiple of 32");
  ExpectRefused("file: a.pt\nmean: [1, 2]\n", "three numbers");
  ExpectRefused("file: a.pt\nstd: [1, 0, 1]\n", "greater than 0");
  ExpectRefused("file: a.pt\nclasses: [7, 23]\n", "CARLA ids");
  ExpectRefused("file: a.pt\nclasses: [7, 1.5]\n", "CARLA ids");
  ExpectRefused("file: a.pt\nclasses: [7]\n", "two channels");
  ExpectRefused("file: a.pt\nclasses: cityscapes\n", "classes");
  ExpectRefused("file: a.pt\nweights: b.pt\n", "weights");
  EXPECT_EQ(SegmentationModel::FromFile("/nowhere/model.yaml").status().code(), absl::StatusCode::kNotFound);
}

TEST(SegmentationModel, TheNetworkSizeKeepsAreaAndProportions) {
  SegmentationModel model;
  model.input_width = 512;
  model.input_height = 384;
  EXPECT_EQ(model.NetworkSize({512, 384}), cv::Size(512, 384));
  EXPECT_EQ(model.NetworkSize({800, 600}), cv::Size(512, 384));
  EXPECT_EQ(model.NetworkSize({1241, 376}), cv::Size(800, 256));
  EXPECT_EQ(model.NetworkSize({100, 5000}), cv::Size(64, 3136));
  EXPECT_EQ(model.NetworkSize({10, 50000}).width, 32);
}

TEST(SegmentationModel, TheInputIsRedGreenBlueNormalized) {
  SegmentationModel model;
  model.mean = {0.5F, 0.25F, 0.0F};
  model.std = {0.5F, 0.25F, 2.0F};
  std::vector<float> planes(3 * 32 * 64);
  const cv::Mat image(40, 100, CV_8UC3, cv::Scalar(255, 0, 51));  // blue, green, red
  FillNetworkInput(model, image, {64, 32}, planes.data());
  for (size_t i = 0; i < 32 * 64; ++i) {
    EXPECT_NEAR(planes[i], (0.2 - 0.5) / 0.5, 1e-5);
    EXPECT_NEAR(planes[i + 2048], -1.0, 1e-5);
    EXPECT_NEAR(planes[i + 4096], 0.5, 1e-5);
  }
}

TEST(SegmentationModel, GreyCountsForAllColours) {
  const SegmentationModel model;
  cv::Mat grey(32, 64, CV_8UC1);
  cv::randu(grey, 0, 256);
  std::vector<float> planes(3 * 32 * 64);
  FillNetworkInput(model, grey, {64, 32}, planes.data());
  for (size_t i = 0; i < 2048; ++i) {
    EXPECT_NEAR(planes[i], grey.data[i] / 255.0, 1e-6);
    EXPECT_EQ(planes[i], planes[i + 2048]);
    EXPECT_EQ(planes[i], planes[i + 4096]);
  }
}

}  // namespace
}  // namespace semmap
