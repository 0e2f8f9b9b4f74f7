// What our ORB extractor finds in the town: keypoints of a frame, how they spread, what they lie on, and how
// many of the matches to a frame one to two metres on agree with the true motion. `town_features` prints
// medians over places along routes 2 and 3, without traffic.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "CLI/CLI.hpp"
#include "client/town/drive.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/statistics.h"
#include "slam/features/descriptor_search.h"
#include "slam/features/orb_extractor.h"

namespace semmap {
namespace {

using town::DriveConfig;
using town::DriveFrame;
using town::TownDrive;

constexpr int kCells = 8;                 // the spread is counted on a grid of 8 x 8
constexpr double kMetresApart = 1.2;      // at least, between the two frames of a pair
constexpr double kInlierPixels = 3;       // at the first pyramid level
constexpr int kFramesBetweenPlaces = 60;  // three seconds

struct Figures {
  std::vector<double> keypoints;
  std::vector<double> cells;
  std::vector<double> inliers;
  std::vector<double> metres;
  std::array<int64_t, town::kClassCount> on_class{};
};

struct Seen {
  DriveFrame frame;
  FrameFeatures features;
};

void Look(OrbExtractor* extractor, Seen* seen) {
  cv::Mat grey;
  cv::cvtColor(seen->frame.left.rgb, grey, cv::COLOR_RGB2GRAY);
  extractor->Extract(grey, &seen->features);
}

int CellsHit(const FrameFeatures& features, const CameraIntrinsics& camera) {
  std::set<int> cells;
  for (const Keypoint& keypoint : features.keypoints) {
    const int column = static_cast<int>(keypoint.x * kCells / static_cast<float>(camera.width));
    const int row = static_cast<int>(keypoint.y * kCells / static_cast<float>(camera.height));
    cells.insert(row * kCells + column);
  }
  return static_cast<int>(cells.size());
}

cv::Point PixelOf(const Keypoint& keypoint) { return {cvRound(keypoint.x), cvRound(keypoint.y)}; }

// Where what a keypoint of `a` lies on is seen in `b`, by the true depth and motion.
bool AgreesWithTruth(const Seen& a, const Keypoint& from, const Seen& b, const Keypoint& to,
                     const CameraIntrinsics& camera, const ScalePyramidInfo& scales) {
  const float depth = a.frame.left.depth.at<float>(PixelOf(from));
  if (depth <= 0) return false;
  const Eigen::Vector3d point_in_a = RayOfPixel(camera, {from.x, from.y}) * depth;
  const Eigen::Vector3d point_in_b =
      b.frame.town_from_camera.Inverse() * (a.frame.town_from_camera * point_in_a);
  if (point_in_b.z() < 0.1) return false;
  const Eigen::Vector2d error = ProjectPinhole(camera, point_in_b) - Eigen::Vector2d(to.x, to.y);
  return error.norm() < kInlierPixels * scales.scales[static_cast<size_t>(to.octave)];
}

int CountInliers(const Seen& a, const Seen& b, const CameraIntrinsics& camera,
                 const ScalePyramidInfo& scales) {
  int inliers = 0;
  for (size_t i = 0; i < a.features.size(); ++i) {
    const NearestTwo there = FindNearestTwo(a.features.descriptors[i], b.features.descriptors);
    if (there.index < 0) continue;
    const auto j = static_cast<size_t>(there.index);
    const NearestTwo back = FindNearestTwo(b.features.descriptors[j], a.features.descriptors);
    if (back.index != static_cast<int>(i)) continue;
    inliers +=
        AgreesWithTruth(a, a.features.keypoints[i], b, b.features.keypoints[j], camera, scales) ? 1 : 0;
  }
  return inliers;
}

// False at the end of the route.
absl::StatusOr<bool> LookAtNextPlace(TownDrive* drive, OrbExtractor* extractor, Figures* figures) {
  Seen first;
  Seen second;
  for (int i = 0; i < kFramesBetweenPlaces; ++i) drive->Skip();
  SEMMAP_ASSIGN_OR_RETURN(const bool more, drive->Next(&first.frame));
  if (!more) return false;
  const double start = drive->simulation().Ego().travelled;
  do {
    SEMMAP_ASSIGN_OR_RETURN(const bool again, drive->Next(&second.frame));
    if (!again) return false;
  } while (drive->simulation().Ego().travelled < start + kMetresApart);
  const CameraIntrinsics camera = drive->config().rig.Intrinsics();
  Look(extractor, &first);
  Look(extractor, &second);
  figures->keypoints.push_back(static_cast<double>(first.features.size()));
  figures->cells.push_back(CellsHit(first.features, camera));
  figures->inliers.push_back(CountInliers(first, second, camera, extractor->scale_info()));
  figures->metres.push_back(drive->simulation().Ego().travelled - start);
  for (const Keypoint& keypoint : first.features.keypoints) {
    ++figures->on_class[first.frame.left.mask.at<uint8_t>(PixelOf(keypoint))];
  }
  return true;
}

void Print(const Figures& figures) {
  std::printf("places                  %zu\n", figures.keypoints.size());
  std::printf("keypoints, median       %.0f\n", Percentile(figures.keypoints, 0.5));
  std::printf("cells of 64, median     %.0f\n", Percentile(figures.cells, 0.5));
  std::printf("metres apart            %.1f to %.1f\n",
              *std::min_element(figures.metres.begin(), figures.metres.end()),
              *std::max_element(figures.metres.begin(), figures.metres.end()));
  std::printf("true inliers, median    %.0f, least %.0f\n", Percentile(figures.inliers, 0.5),
              *std::min_element(figures.inliers.begin(), figures.inliers.end()));
  int64_t total = 0;
  for (const int64_t count : figures.on_class) total += count;
  for (size_t i = 0; i < figures.on_class.size(); ++i) {
    std::printf("%-15.*s %5.1f %%\n", static_cast<int>(town::kClasses[i].name.size()),
                town::kClasses[i].name.data(),
                100 * static_cast<double>(figures.on_class[i]) / static_cast<double>(total));
  }
}

absl::Status Run(DriveConfig config, const std::vector<std::string>& routes) {
  const town::World world(town::NetworkConfig(), config.seed);
  OrbExtractor extractor{OrbConfig()};
  Figures figures;
  config.traffic = {0, 0};
  for (const std::string& route : routes) {
    config.route = route;
    SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<TownDrive> drive, TownDrive::Create(config, &world));
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool more, LookAtNextPlace(drive.get(), &extractor, &figures));
      if (!more) break;
    }
  }
  if (figures.keypoints.empty()) return absl::InternalError("no place was seen");
  Print(figures);
  return absl::OkStatus();
}

}  // namespace
}  // namespace semmap

int main(int argc, char** argv) {
  CLI::App app("Keypoints in the simulated town");
  semmap::town::DriveConfig config;
  std::vector<std::string> routes = {"2", "3"};
  app.add_option("--seed", config.seed, "Seed of the town")->capture_default_str();
  app.add_option("--routes", routes, "Routes to drive")->delimiter(',')->capture_default_str();
  app.add_option("--weather", config.weather)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = semmap::Run(config, routes);
  if (!status.ok()) std::fprintf(stderr, "town_features: %s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
