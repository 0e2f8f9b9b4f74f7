#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "client/sources/open_source.h"

namespace semmap::client {

// The folder of shared data, or empty when it is not there.
inline std::string SharedDataFolder() {
  const char* shared = std::getenv("SEMMAP_SHARED");
  const std::filesystem::path folder =
      (shared != nullptr ? std::filesystem::path(shared)
                         : std::filesystem::path(SEMMAP_SOURCE_DIR) / ".." / "shared") /
      "data";
  return std::filesystem::is_directory(folder) ? folder.string() : std::string();
}

// A folder of its own for each test, removed at the end.
class SourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    root_ = std::filesystem::path(::testing::TempDir()) /
            (std::string("semmap_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  std::string Path(const std::string& name) const { return (root_ / name).string(); }

  void WriteText(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name, std::ios::binary) << text;
  }
  // A small image, `level` everywhere; the extension decides the format.
  void WriteGray(const std::string& name, int level, cv::Size size = {64, 48}) const {
    std::filesystem::create_directories((root_ / name).parent_path());
    ASSERT_TRUE(cv::imwrite(Path(name), cv::Mat(size, CV_8UC1, cv::Scalar(level))));
  }
  void WriteDepth(const std::string& name, int value) const {
    std::filesystem::create_directories((root_ / name).parent_path());
    ASSERT_TRUE(cv::imwrite(Path(name), cv::Mat(48, 64, CV_16UC1, cv::Scalar(value))));
  }

  std::filesystem::path root_;
};

// Grey level of the middle pixel.
inline int LevelOf(const SourceImage& image) {
  const auto pixels = DecodeGray(image);
  return pixels.ok() ? pixels->at<uint8_t>(pixels->rows / 2, pixels->cols / 2) : -1;
}

// Plays to the end; the number of frames or -1 after an error.
inline int CountFrames(FrameSource& source) {
  int frames = 0;
  while (true) {
    const auto frame = source.Next();
    if (!frame.ok()) return -1;
    if (!frame->has_value()) return frames;
    ++frames;
  }
}

inline SourceOptions ForSensor(SensorType sensor, const std::string& camera_file = "") {
  return {sensor, camera_file};
}

constexpr char kSmallCamera[] = "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 32\ncy: 24\n";

}  // namespace semmap::client
