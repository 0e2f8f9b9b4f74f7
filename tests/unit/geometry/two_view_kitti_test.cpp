// Two-view reconstruction on real images. Matches of a street seen from a moving car have what synthetic ones
// lack: small parallax, errors that depend on the pyramid level, and several motions that explain almost all
// of them.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slam/geometry/two_view.h"

namespace semmap {
namespace {

namespace fs = std::filesystem;

fs::path SequenceFolder() {
  const char* shared = std::getenv("SEMMAP_SHARED");
  const fs::path root = shared != nullptr ? fs::path(shared) : fs::path(SEMMAP_SOURCE_DIR) / ".." / "shared";
  return root / "data" / "sequences" / "kitti00_mono200";
}

std::vector<SE3> ReadKittiPoses(const fs::path& path) {
  std::ifstream file(path);
  std::vector<SE3> poses;
  for (std::string line; std::getline(file, line);) {
    std::istringstream numbers(line);
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 12; ++i) numbers >> matrix(i / 4, i % 4);
    poses.push_back(SE3::FromMatrix(matrix));
  }
  return poses;
}

struct ImageFeatures {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};

ImageFeatures Extract(const fs::path& folder, int index) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06d.png", index);
  const cv::Mat image = cv::imread((folder / "image_0" / name).string(), cv::IMREAD_GRAYSCALE);
  ImageFeatures features;
  cv::ORB::create(1500)->detectAndCompute(image, cv::noArray(), features.keypoints, features.descriptors);
  return features;
}

struct PixelMatches {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
};

PixelMatches Match(const ImageFeatures& first, const ImageFeatures& second) {
  std::vector<std::vector<cv::DMatch>> neighbours;
  cv::BFMatcher(cv::NORM_HAMMING).knnMatch(first.descriptors, second.descriptors, neighbours, 2);
  PixelMatches matches;
  for (const std::vector<cv::DMatch>& pair : neighbours) {
    if (pair.size() < 2 || pair[0].distance > 50 || pair[0].distance > 0.8F * pair[1].distance) continue;
    const cv::Point2f a = first.keypoints[pair[0].queryIdx].pt;
    const cv::Point2f b = second.keypoints[pair[0].trainIdx].pt;
    matches.first.emplace_back(a.x, a.y);
    matches.second.emplace_back(b.x, b.y);
  }
  return matches;
}

TEST(ReconstructTwoViews, IsRightOrSilentOnKitti) {
  const fs::path folder = SequenceFolder();
  if (!fs::exists(folder / "poses.txt")) GTEST_SKIP() << "no KITTI sequence at " << folder;
  const CameraIntrinsics camera = {
      .width = 1241, .height = 376, .fx = 718.856, .fy = 718.856, .cx = 607.1928, .cy = 185.2157};
  const std::vector<SE3> map_from_camera = ReadKittiPoses(folder / "poses.txt");
  ASSERT_EQ(map_from_camera.size(), 200U);
  int reconstructed = 0;
  // Straight on, and through the bend from frame 120 on; near pairs, where rotation poses as translation, and
  // far ones.
  for (const auto& [from, to] : std::vector<std::pair<int, int>>{{10, 11},
                                                                 {70, 71},
                                                                 {120, 121},
                                                                 {140, 141},
                                                                 {170, 171},
                                                                 {10, 12},
                                                                 {80, 82},
                                                                 {90, 92},
                                                                 {140, 142},
                                                                 {150, 152},
                                                                 {20, 23},
                                                                 {80, 83},
                                                                 {140, 143},
                                                                 {10, 15},
                                                                 {50, 55},
                                                                 {80, 85},
                                                                 {120, 125}}) {
    const PixelMatches matches = Match(Extract(folder, from), Extract(folder, to));
    const auto result =
        ReconstructTwoViews(camera, matches.first, matches.second, {.min_parallax_rad = 0.009});
    if (!result) continue;
    ++reconstructed;
    const SE3 truth = map_from_camera[to].Inverse() * map_from_camera[from];
    const SE3& found = result->second_from_first;
    EXPECT_LT((found.Inverse() * truth).RotationAngle(), 0.015) << from << " to " << to;
    EXPECT_GT(found.translation().dot(truth.translation().normalized()), std::cos(0.15))
        << from << " to " << to;
  }
  EXPECT_GE(reconstructed, 8);
}

}  // namespace
}  // namespace semmap
