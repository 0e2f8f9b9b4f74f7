#include "slam/geometry/camera.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace semmap {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

CameraRig StereoRig() {
  CameraRig rig;
  rig.sensor = SensorType::kStereo;
  rig.camera = {.width = 1241, .height = 376, .fx = 718.9, .fy = 718.9, .cx = 607.2, .cy = 185.2};
  rig.baseline_m = 0.537;
  return rig;
}

CameraIntrinsics DistortedCamera(DistortionModel model, const std::array<double, 5>& distortion) {
  CameraIntrinsics camera = {.width = 752, .height = 480, .fx = 458.7, .fy = 457.3, .cx = 367.2, .cy = 248.4};
  camera.distortion_model = model;
  camera.distortion = distortion;
  return camera;
}

// The forward models, written out from their definitions.
Eigen::Vector2d DistortRadialTangential(const Eigen::Vector2d& ideal, const std::array<double, 5>& k) {
  const double x = ideal.x();
  const double y = ideal.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

Eigen::Vector2d DistortEquidistant(const Eigen::Vector2d& ideal, const std::array<double, 5>& k) {
  const double radius = ideal.norm();
  const double theta = std::atan(radius);
  const double t2 = theta * theta;
  return ideal * theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / radius;
}

template <typename Distort>
void ExpectUndistortInverts(const CameraIntrinsics& camera, Distort distort, double max_radius) {
  for (double x = -max_radius; x <= max_radius; x += 0.13) {
    for (double y = -0.5 * max_radius; y <= 0.5 * max_radius; y += 0.11) {
      const Eigen::Vector2d raw = distort({x, y}, camera.distortion);
      std::vector<Eigen::Vector2f> pixels = {
          Eigen::Vector2d(camera.fx * raw.x() + camera.cx, camera.fy * raw.y() + camera.cy).cast<float>()};
      UndistortPixels(camera, &pixels);
      EXPECT_NEAR(pixels[0].x(), camera.fx * x + camera.cx, 0.02) << x << " " << y;
      EXPECT_NEAR(pixels[0].y(), camera.fy * y + camera.cy, 0.02) << x << " " << y;
    }
  }
}

TEST(ValidateRig, AcceptsRealRigs) {
  EXPECT_TRUE(ValidateRig(StereoRig()).ok());
  CameraRig rgbd = StereoRig();
  rgbd.sensor = SensorType::kRgbd;
  rgbd.baseline_m = 0;
  EXPECT_TRUE(ValidateRig(rgbd).ok());
  CameraRig fisheye = StereoRig();
  fisheye.sensor = SensorType::kMono;
  fisheye.camera.distortion_model = DistortionModel::kEquidistant;
  EXPECT_TRUE(ValidateRig(fisheye).ok());
}

struct BadRig {
  const char* field;
  void (*spoil)(CameraRig&);
};

class ValidateRigRefuses : public testing::TestWithParam<BadRig> {};

TEST_P(ValidateRigRefuses, NamesTheField) {
  CameraRig rig = StereoRig();
  GetParam().spoil(rig);
  const absl::Status status = ValidateRig(rig);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().field));
}

INSTANTIATE_TEST_SUITE_P(
    Fields, ValidateRigRefuses,
    testing::Values(
        BadRig{"width", [](CameraRig& rig) { rig.camera.width = 0; }},
        BadRig{"height", [](CameraRig& rig) { rig.camera.height = 1 << 20; }},
        BadRig{"fx", [](CameraRig& rig) { rig.camera.fx = -1; }},
        BadRig{"fx", [](CameraRig& rig) { rig.camera.fx = 0; }},
        BadRig{"fy", [](CameraRig& rig) { rig.camera.fy = kNan; }},
        BadRig{"cx", [](CameraRig& rig) { rig.camera.cx = 1241; }},
        BadRig{"cy", [](CameraRig& rig) { rig.camera.cy = -3; }},
        BadRig{"distortion",
               [](CameraRig& rig) { rig.camera.distortion_model = DistortionModel::kEquidistant; }},
        BadRig{"distortion",
               [](CameraRig& rig) {
                 rig.sensor = SensorType::kMono;
                 rig.camera.distortion_model = DistortionModel::kRadialTangential;
                 rig.camera.distortion[2] = kNan;
               }},
        BadRig{"distortion_model",
               [](CameraRig& rig) { rig.camera.distortion_model = static_cast<DistortionModel>(17); }},
        BadRig{"sensor", [](CameraRig& rig) { rig.sensor = static_cast<SensorType>(17); }},
        BadRig{"baseline_m", [](CameraRig& rig) { rig.baseline_m = 0; }},
        BadRig{"baseline_m", [](CameraRig& rig) { rig.baseline_m = kNan; }},
        BadRig{"depth_units",
               [](CameraRig& rig) {
                 rig.sensor = SensorType::kRgbd;
                 rig.depth_units_per_metre = 0;
               }},
        BadRig{"frames_per_second", [](CameraRig& rig) { rig.frames_per_second = 0; }},
        BadRig{"body_from_camera", [](CameraRig& rig) {
                 rig.body_from_camera = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, kNan, 0));
               }}));

TEST(UndistortPixels, InvertsRadialTangential) {
  const auto camera = DistortedCamera(DistortionModel::kRadialTangential, {-0.283, 0.074, 1.9e-4, 1.8e-5, 0});
  ExpectUndistortInverts(camera, DistortRadialTangential, 0.8);
}

TEST(UndistortPixels, InvertsEquidistant) {
  const auto camera = DistortedCamera(DistortionModel::kEquidistant, {0.0034, 0.0007, -0.002, 0.0002, 0});
  ExpectUndistortInverts(camera, DistortEquidistant, 1.7);
}

TEST(UndistortPixels, LeavesPinholeAndEmptyAlone) {
  CameraIntrinsics camera = DistortedCamera(DistortionModel::kNone, {1, 1, 1, 1, 1});
  std::vector<Eigen::Vector2f> pixels = {{3.25F, 7.5F}};
  UndistortPixels(camera, &pixels);
  EXPECT_EQ(pixels[0], Eigen::Vector2f(3.25F, 7.5F));
  camera.distortion_model = DistortionModel::kRadialTangential;
  pixels.clear();
  UndistortPixels(camera, &pixels);
  EXPECT_TRUE(pixels.empty());
}

TEST(UndistortedBounds, IsTheImageOfAPinhole) {
  const ImageBounds bounds = UndistortedBounds(StereoRig().camera);
  EXPECT_EQ(bounds.min_x, 0);
  EXPECT_EQ(bounds.max_y, 376);
  EXPECT_TRUE(bounds.Contains(0, 375.9F));
  EXPECT_FALSE(bounds.Contains(1241, 10));
}

TEST(UndistortedBounds, HoldsEveryUndistortedPixel) {
  const auto camera = DistortedCamera(DistortionModel::kRadialTangential, {-0.283, 0.074, 1.9e-4, 1.8e-5, 0});
  const ImageBounds bounds = UndistortedBounds(camera);
  std::vector<Eigen::Vector2f> pixels;
  for (int x = 0; x < camera.width; x += 5) {
    for (int y = 0; y < camera.height; y += 5)
      pixels.emplace_back(static_cast<float>(x), static_cast<float>(y));
  }
  UndistortPixels(camera, &pixels);
  for (const Eigen::Vector2f& pixel : pixels) ASSERT_TRUE(bounds.Contains(pixel.x(), pixel.y()));
  EXPECT_LT(bounds.min_x, -20);  // barrel distortion: the corners move outwards
  EXPECT_GT(bounds.min_x, -400);
}

TEST(UndistortedBounds, StaysFiniteForAWideFisheye) {
  auto camera = DistortedCamera(DistortionModel::kEquidistant, {});
  camera.fx = camera.fy = 240;  // 752 px at 240 px/rad: 180 degrees across
  const ImageBounds bounds = UndistortedBounds(camera);
  EXPECT_GE(bounds.min_x, -2 * camera.width);
  EXPECT_LE(bounds.max_x, 3 * camera.width);
  EXPECT_LT(bounds.min_x, 0);
  EXPECT_GT(bounds.max_x, camera.width);
}

}  // namespace
}  // namespace semmap
