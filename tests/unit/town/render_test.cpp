#include "client/town/renderer.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "client/town/dataset_writer.h"
#include "client/town/drive.h"
#include "client/town/spawn_points.h"

namespace semmap::town {
namespace {

// One small town for all tests of this file.
const World& TestWorld() {
  static const World world(NetworkConfig(), 1);
  return world;
}

DriveConfig SmallDrive() {
  DriveConfig config;
  config.rig.width = 320;
  config.rig.height = 240;
  config.traffic = {10, 6};
  config.max_frames = 4;
  return config;
}

#define SKIP_WITHOUT_EGL(result)                                                  \
  if (absl::IsUnavailable((result).status())) {                                   \
    GTEST_SKIP() << "no off-screen OpenGL here: " << (result).status().message(); \
  }                                                                               \
  ASSERT_TRUE((result).ok()) << (result).status()

SE3 Look(const glm::dvec2& at, double heading, const RigConfig& rig) {
  EgoState ego;
  ego.position = {at.x, at.y, 0};
  ego.heading = heading;
  return TownFromVehicle(ego) * rig.VehicleFromCamera();
}

struct Scene {
  RigConfig rig;
  std::unique_ptr<Renderer> renderer;
};

absl::StatusOr<Scene> MakeScene(const std::string& weather = "noon") {
  Scene scene;
  scene.rig = SmallDrive().rig;
  RenderConfig config;
  config.camera = scene.rig.Intrinsics();
  auto renderer = Renderer::Create(TestWorld(), config, *MakeWeather(weather));
  if (!renderer.ok()) return renderer.status();
  scene.renderer = *std::move(renderer);
  return scene;
}

// Metres above the town's zero level at each pixel.
double HeightAt(const Scene& scene, const SE3& town_from_camera, const View& view, int x, int y) {
  const Eigen::Vector3d ray = RayOfPixel(scene.rig.Intrinsics(), {x, y});
  return (town_from_camera * (ray * view.depth.at<float>(y, x))).z();
}

TEST(Renderer, SameSeedSameBytes) {
  std::vector<cv::Mat> images[2];
  for (auto& list : images) {
    auto drive = TownDrive::Create(SmallDrive(), &TestWorld());
    SKIP_WITHOUT_EGL(drive);
    DriveFrame frame;
    while (*(*drive)->Next(&frame)) {
      list.push_back(frame.left.rgb.clone());
      list.push_back(frame.left.mask.clone());
      list.push_back(frame.left.depth.clone());
    }
  }
  ASSERT_EQ(images[0].size(), 12U);
  for (size_t i = 0; i < images[0].size(); ++i)
    EXPECT_EQ(cv::norm(images[0][i], images[1][i], cv::NORM_INF), 0);
}

TEST(Renderer, RoadIsWhereItsDepthSays) {
  auto scene = MakeScene();
  SKIP_WITHOUT_EGL(scene);
  View view;
  int checked = 0;
  for (const SpawnPoint& point : SpawnPoints(TestWorld().network(), 12)) {
    const SE3 pose = Look(point.position, point.heading, scene->rig);
    ASSERT_TRUE(scene->renderer->Render(pose, {}, 0, &view).ok());
    for (int y = 130; y < 236; y += 7) {
      for (int x = 4; x < 316; x += 7) {
        if (view.mask.at<uint8_t>(y, x) != static_cast<uint8_t>(ClassId::kRoad)) continue;
        if (view.depth.at<float>(y, x) > 40) continue;
        EXPECT_NEAR(HeightAt(*scene, pose, view, x, y), 0.0, 0.02 + 0.002 * view.depth.at<float>(y, x));
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 1000);
}

TEST(Renderer, SkyHasNoDepthAndEverythingElseHas) {
  auto scene = MakeScene();
  SKIP_WITHOUT_EGL(scene);
  View view;
  const SpawnPoint point = SpawnPoints(TestWorld().network(), 12)[3];
  ASSERT_TRUE(scene->renderer->Render(Look(point.position, point.heading, scene->rig), {}, 0, &view).ok());
  const cv::Mat sky = view.mask == static_cast<uint8_t>(ClassId::kSky);
  const cv::Mat no_depth = view.depth == 0;
  EXPECT_EQ(cv::countNonZero(sky != no_depth), 0);
  EXPECT_GT(cv::countNonZero(sky), 500);
}

// A cube of two metres, ten metres ahead: image, mask and depth have it at the pixels where it projects to.
TEST(Renderer, AKnownCubeProjectsToItsPixels) {
  auto scene = MakeScene();
  SKIP_WITHOUT_EGL(scene);
  MeshBuilder cube;
  cube.Box({0, 0, -1}, {1, 0}, {2, 2, 2}, MakeSurface(Texture::kPaint, ClassId::kOther), true);
  const int model = scene->renderer->AddModel(cube);
  const Lane& lane = TestWorld().network().lanes()[0];
  const double s = lane.path.length() / 2;
  const glm::dvec2 ahead = lane.path.TangentAt(s);
  const SE3 pose = Look(lane.path.PointAt(s), std::atan2(ahead.y, ahead.x), scene->rig);
  const Eigen::Vector3d middle = pose * Eigen::Vector3d(0.5, 0.25, 11);
  glm::mat4 place = glm::translate(glm::mat4(1), glm::vec3(glm::dvec3(middle.x(), middle.y(), middle.z())));
  place = glm::rotate(place, static_cast<float>(std::atan2(ahead.y, ahead.x)), glm::vec3(0, 0, 1));
  View view;
  ASSERT_TRUE(scene->renderer->Render(pose, {{model, place, false}}, 0, &view).ok());
  // The near face is 10 m away: x in [-0.5, 1.5], y in [-0.75, 1.25] in front of the camera.
  const CameraIntrinsics camera = scene->rig.Intrinsics();
  const Eigen::Vector2d low = ProjectPinhole(camera, {-0.5, -0.75, 10});
  const Eigen::Vector2d high = ProjectPinhole(camera, {1.5, 1.25, 10});
  const auto class_at = [&](double x, double y) {
    return view.mask.at<uint8_t>(static_cast<int>(std::lround(y)), static_cast<int>(std::lround(x)));
  };
  const auto cube_class = static_cast<uint8_t>(ClassId::kOther);
  const double mid_x = (low.x() + high.x()) / 2;
  const double mid_y = (low.y() + high.y()) / 2;
  EXPECT_EQ(class_at(mid_x, mid_y), cube_class);
  EXPECT_NEAR(view.depth.at<float>(static_cast<int>(mid_y), static_cast<int>(mid_x)), 10.0, 0.005);
  // One pixel inside it is there, one pixel outside of the left and the upper edge it is not.
  EXPECT_EQ(class_at(low.x() + 1, mid_y), cube_class);
  EXPECT_NE(class_at(low.x() - 1, mid_y), cube_class);
  EXPECT_EQ(class_at(mid_x, low.y() + 1), cube_class);
  EXPECT_NE(class_at(mid_x, low.y() - 1), cube_class);
  EXPECT_EQ(class_at(high.x() - 1, mid_y), cube_class);
  EXPECT_NE(class_at(high.x() + 1, mid_y), cube_class);
}

// Along a row, the patch around a pixel of the left image looks most like the one in the right image at the
// place that the pixel's depth foretells.
TEST(Renderer, DisparityAgreesWithDepth) {
  DriveConfig config = SmallDrive();
  config.rig.width = 640;
  config.rig.height = 480;
  config.stereo = true;
  config.max_frames = 1;
  auto drive = TownDrive::Create(config, &TestWorld());
  SKIP_WITHOUT_EGL(drive);
  DriveFrame frame;
  ASSERT_TRUE(*(*drive)->Next(&frame));
  cv::Mat left;
  cv::Mat right;
  cv::cvtColor(frame.left.rgb, left, cv::COLOR_RGB2GRAY);
  cv::cvtColor(frame.right_rgb, right, cv::COLOR_RGB2GRAY);
  const double f_b = config.rig.Intrinsics().fx * config.rig.baseline_m;
  constexpr int kHalf = 6;
  int good = 0;
  int tried = 0;
  for (int y = 20; y < 460; y += 9) {
    for (int x = 100; x < 620; x += 9) {
      const cv::Rect patch(x - kHalf, y - kHalf, 2 * kHalf + 1, 2 * kHalf + 1);
      double low = 0;
      double high = 0;
      cv::minMaxLoc(frame.left.depth(patch), &low, &high);
      cv::Scalar mean;
      cv::Scalar deviation;
      cv::meanStdDev(left(patch), mean, deviation);
      if (low <= 0 || high > low * 1.1 || deviation[0] < 10) continue;  // an edge, or nothing to match
      const double expected = f_b / frame.left.depth.at<float>(y, x);
      if (expected < 2 || x - expected - 8 < kHalf) continue;
      const int span = 6;
      const cv::Rect search(x - static_cast<int>(expected) - span - kHalf, y - kHalf, 2 * (kHalf + span) + 1,
                            2 * kHalf + 1);
      if ((search & cv::Rect(0, 0, right.cols, right.rows)) != search) continue;
      cv::Mat score;
      cv::matchTemplate(right(search), left(patch), score, cv::TM_CCOEFF_NORMED);
      cv::Point best;
      cv::minMaxLoc(score, nullptr, nullptr, nullptr, &best);
      const double disparity = x - (search.x + best.x + kHalf);
      ++tried;
      good += std::abs(disparity - expected) < 1.2 ? 1 : 0;
    }
  }
  ASSERT_GT(tried, 200);
  EXPECT_GT(static_cast<double>(good) / tried, 0.9) << good << " of " << tried;
}

TEST(Renderer, AllClassesOfAStreetCanBeSeen) {
  auto scene = MakeScene();
  SKIP_WITHOUT_EGL(scene);
  std::set<int> seen;
  View view;
  for (const SpawnPoint& point : SpawnPoints(TestWorld().network(), 60)) {
    for (const double turn : {0.0, 1.57, 3.14, 4.71}) {
      ASSERT_TRUE(
          scene->renderer->Render(Look(point.position, point.heading + turn, scene->rig), {}, 0, &view).ok());
      for (int y = 0; y < view.mask.rows; ++y) {
        for (int x = 0; x < view.mask.cols; ++x) seen.insert(view.mask.at<uint8_t>(y, x));
      }
    }
  }
  for (int id = 0; id < kClassCount; ++id) {
    if (id == static_cast<int>(ClassId::kPedestrian)) continue;  // they move: not part of the world
    EXPECT_TRUE(seen.contains(id)) << kClasses[static_cast<size_t>(id)].name;
  }
  for (const int id : seen) EXPECT_LT(id, kClassCount);
}

TEST(Renderer, PeopleAndVehiclesAreSeen) {
  DriveConfig config = SmallDrive();
  config.traffic = {40, 60};
  config.max_frames = 0;
  auto drive = TownDrive::Create(config, &TestWorld());
  SKIP_WITHOUT_EGL(drive);
  DriveFrame frame;
  int people = 0;
  int vehicles = 0;
  for (int i = 0; i < 20; ++i) {
    for (int skip = 0; skip < 15; ++skip) (*drive)->Skip();
    ASSERT_TRUE(*(*drive)->Next(&frame));
    people += cv::countNonZero(frame.left.mask == static_cast<uint8_t>(ClassId::kPedestrian));
    vehicles += cv::countNonZero(frame.left.mask == static_cast<uint8_t>(ClassId::kVehicles));
  }
  EXPECT_GT(people, 100);
  EXPECT_GT(vehicles, 2000);
}

TEST(Renderer, WeathersDifferInLightOnly) {
  auto noon = MakeScene("noon");
  SKIP_WITHOUT_EGL(noon);
  const SpawnPoint point = SpawnPoints(TestWorld().network(), 12)[5];
  const SE3 pose = Look(point.position, point.heading, noon->rig);
  View reference;
  ASSERT_TRUE(noon->renderer->Render(pose, {}, 0, &reference).ok());
  for (const char* name : {"dusk", "overcast"}) {
    auto other = MakeScene(name);
    ASSERT_TRUE(other.ok());
    View view;
    ASSERT_TRUE(other->renderer->Render(pose, {}, 0, &view).ok());
    EXPECT_EQ(cv::norm(view.mask, reference.mask, cv::NORM_INF), 0) << name;
    EXPECT_GT(cv::norm(view.rgb, reference.rgb, cv::NORM_L1) / static_cast<double>(view.rgb.total()), 15)
        << name;
  }
}

TEST(TownDrive, RefusesWhatItCannotDo) {
  DriveConfig config = SmallDrive();
  config.route = "nowhere";
  EXPECT_EQ(TownDrive::Create(config, &TestWorld()).status().code(), absl::StatusCode::kNotFound);
  config = SmallDrive();
  config.weather = "frogs";
  EXPECT_EQ(TownDrive::Create(config, &TestWorld()).status().code(), absl::StatusCode::kInvalidArgument);
  config = SmallDrive();
  config.traffic.vehicles = 1000;
  EXPECT_EQ(TownDrive::Create(config, &TestWorld()).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(DatasetWriter, WritesWhatAReaderOfKittiNeeds) {
  DriveConfig config = SmallDrive();
  config.stereo = true;
  auto drive = TownDrive::Create(config, &TestWorld());
  SKIP_WITHOUT_EGL(drive);
  const std::string folder = testing::TempDir() + "/town_dataset_test";
  std::filesystem::remove_all(folder);
  auto writer = DatasetWriter::Create(folder, **drive, {});
  ASSERT_TRUE(writer.ok()) << writer.status();
  DriveFrame frame;
  while (*(*drive)->Next(&frame)) ASSERT_TRUE((*writer)->Write(frame).ok());
  ASSERT_TRUE((*writer)->Finish().ok());
  EXPECT_EQ(DatasetWriter::Create(folder, **drive, {}).status().code(), absl::StatusCode::kAlreadyExists);

  const cv::Mat left = cv::imread(folder + "/image_0/000003.png", cv::IMREAD_COLOR);
  cv::cvtColor(frame.left.rgb, frame.left.rgb, cv::COLOR_RGB2BGR);
  EXPECT_EQ(cv::norm(left, frame.left.rgb, cv::NORM_INF), 0);
  EXPECT_FALSE(cv::imread(folder + "/image_1/000003.png").empty());
  const cv::Mat mask = cv::imread(folder + "/class/000003.png", cv::IMREAD_UNCHANGED);
  EXPECT_EQ(cv::norm(mask, frame.left.mask, cv::NORM_INF), 0);
  const cv::Mat depth = cv::imread(folder + "/depth/000003.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_16UC1);
  EXPECT_NEAR(depth.at<uint16_t>(220, 160), frame.left.depth.at<float>(220, 160) * 1000, 1);

  std::ifstream poses(folder + "/poses.txt");
  std::string line;
  std::getline(poses, line);
  EXPECT_EQ(line.substr(0, 8), "1 0 0 0 ");
  int lines = 1;
  while (std::getline(poses, line)) ++lines;
  EXPECT_EQ(lines, 4);
  std::ifstream calibration(folder + "/calib.txt");
  std::getline(calibration, line);
  EXPECT_EQ(line, "P0: 160 0 159.5 0 0 160 119.5 0 0 0 1 0");
  std::getline(calibration, line);
  EXPECT_EQ(line, "P1: 160 0 159.5 -80 0 160 119.5 0 0 0 1 0");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace semmap::town
