#include <cmath>

#include <gmock/gmock.h>
#include <opencv2/calib3d.hpp>

#include "client/sources/euroc_calibration.h"
#include "client/sources/stereo_rectifier.h"
#include "tests/unit/sources/source_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

// The published calibration of the data set's left and right camera.
constexpr char kLeft[] =
    "sensor_type: camera\ncomment: VI-Sensor cam0 (MT9M034)\n"
    "T_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,\n"
    "         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,\n"
    "        -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,\n"
    "         0.0, 0.0, 0.0, 1.0]\n"
    "rate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\n"
    "intrinsics: [458.654, 457.296, 367.215, 248.375]\ndistortion_model: radial-tangential\n"
    "distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n";
constexpr char kRight[] =
    "T_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,\n"
    "         0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,\n"
    "        -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038,\n"
    "         0.0, 0.0, 0.0, 1.0]\n"
    "rate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\n"
    "intrinsics: [457.587, 456.134, 379.999, 255.238]\ndistortion_model: radial-tangential\n"
    "distortion_coefficients: [-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05]\n";

class EurocSource : public SourceTest {
 protected:
  void MakeRecording() {
    WriteText("mav0/cam0/sensor.yaml", kLeft);
    WriteText("mav0/cam1/sensor.yaml", kRight);
    const std::string list =
        "#timestamp "
        "[ns],filename\n1403636579763555584,a.png\n1403636579813555456,b.png\n1403636579863555584,c.png\n";
    WriteText("mav0/cam0/data.csv", list);
    WriteText("mav0/cam1/data.csv",
              "#timestamp [ns],filename\n1403636579763555584,a.png\n1403636579863555584,c.png\n");
    WriteText("mav0/state_groundtruth_estimate0/data.csv",
              "#timestamp, p_RS_R_x [m], ...\n1403636579763555584,1,2,3,1,0,0,0,9,9,9\n");
    for (const char* name : {"a", "b", "c"}) {
      WriteGray(std::string("mav0/cam0/data/") + name + ".png", 80, {752, 480});
      WriteGray(std::string("mav0/cam1/data/") + name + ".png", 90, {752, 480});
    }
  }
  absl::StatusOr<std::unique_ptr<FrameSource>> Open(SensorType sensor) {
    return OpenSource("euroc:" + root_.string(), ForSensor(sensor));
  }
};

TEST_F(EurocSource, MonoIsRawWithItsDistortion) {
  MakeRecording();
  const auto source = Open(SensorType::kMono);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->rig().camera.distortion_model, DistortionModel::kRadialTangential);
  EXPECT_DOUBLE_EQ((*source)->rig().camera.fx, 458.654);
  EXPECT_DOUBLE_EQ((*source)->rig().frames_per_second, 20);
  // Body at (1, 2, 3) without rotation: the camera sits at the body's position plus its place on the body.
  EXPECT_TRUE((*source)->ground_truth()->poses[0].map_from_camera.translation().isApprox(
      Eigen::Vector3d(1 - 0.0216401454975, 2 - 0.064676986768, 3 + 0.00981073058949)));
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  EXPECT_EQ((*frame)->timestamp, 1403636579763555584);
  EXPECT_EQ((*frame)->image.encoding, ImageEncoding::kPng);
  EXPECT_EQ(CountFrames(**source), 2);
}

TEST_F(EurocSource, StereoIsRectifiedAndPairedByTime) {
  MakeRecording();
  const auto source = Open(SensorType::kStereo);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->rig().camera.distortion_model, DistortionModel::kNone);
  EXPECT_NEAR((*source)->rig().baseline_m, 0.11007, 1e-4);
  EXPECT_EQ((*source)->frame_count(), 2U);
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  EXPECT_EQ((*frame)->image.pixels.size(), cv::Size(752, 480));
  EXPECT_EQ(LevelOf((*frame)->image), 80);
  EXPECT_EQ(LevelOf((*frame)->right), 90);
}

TEST_F(EurocSource, SaysWhatIsWrong) {
  EXPECT_EQ(Open(SensorType::kMono).status().code(), absl::StatusCode::kNotFound);
  MakeRecording();
  EXPECT_EQ(Open(SensorType::kRgbd).status().code(), absl::StatusCode::kInvalidArgument);
  WriteText("mav0/cam0/data.csv", "soon,a.png\n");
  EXPECT_THAT(std::string(Open(SensorType::kMono).status().message()),
              HasSubstr("data.csv:1: the first field"));
  WriteText("mav0/cam0/sensor.yaml", "resolution: [752]\n");
  EXPECT_THAT(std::string(Open(SensorType::kMono).status().message()), HasSubstr("resolution must be"));
  WriteText("mav0/cam0/sensor.yaml", "a: [\n");
  EXPECT_EQ(Open(SensorType::kMono).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(EurocSource, RefusesAnImageOfAnotherSize) {
  MakeRecording();
  WriteGray("mav0/cam1/data/a.png", 90, {750, 480});
  auto source = Open(SensorType::kStereo);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->Next().status().code(), absl::StatusCode::kInvalidArgument);
}

// Where a raw camera sees a point, by the textbook formulas rather than OpenCV's.
Eigen::Vector2d ProjectRaw(const CameraIntrinsics& camera, const Eigen::Vector3d& point) {
  const double x = point.x() / point.z();
  const double y = point.y() / point.z();
  const auto& d = camera.distortion;
  if (camera.distortion_model == DistortionModel::kEquidistant) {
    const double r = std::hypot(x, y);
    const double t = std::atan(r);
    const double t2 = t * t;
    const double distorted = t * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))));
    return {camera.fx * x * distorted / r + camera.cx, camera.fy * y * distorted / r + camera.cy};
  }
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  const double dx = 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x);
  const double dy = d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y;
  return {camera.fx * (x * radial + dx) + camera.cx, camera.fy * (y * radial + dy) + camera.cy};
}

// Centre of gravity of a bright spot on black.
Eigen::Vector2d Centroid(const cv::Mat& image) {
  const cv::Moments moments = cv::moments(image);
  return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

cv::Mat SpotAt(const CameraIntrinsics& camera, const Eigen::Vector2d& pixel) {
  cv::Mat image(camera.height, camera.width, CV_8UC1, cv::Scalar(0));
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const double distance2 = (Eigen::Vector2d(column, row) - pixel).squaredNorm();
      image.at<uint8_t>(row, column) = static_cast<uint8_t>(255 * std::exp(-distance2 / 18.0) + 0.5);
    }
  }
  return image;
}

void ExpectRectified(const CameraIntrinsics& left, const CameraIntrinsics& right,
                     const SE3& right_from_left) {
  const auto rectifier = StereoRectifier::Create(left, right, right_from_left);
  ASSERT_TRUE(rectifier.ok()) << rectifier.status();
  const Eigen::Vector3d point_in_left(0.4, -0.3, 3.0);
  const Eigen::Vector3d point_in_rectified = rectifier->left_from_rectified().Inverse() * point_in_left;
  const Eigen::Vector2d expected = ProjectPinhole(rectifier->camera(), point_in_rectified);
  const auto left_image = rectifier->RectifyLeft(SpotAt(left, ProjectRaw(left, point_in_left)));
  const auto right_image =
      rectifier->RectifyRight(SpotAt(right, ProjectRaw(right, right_from_left * point_in_left)));
  ASSERT_TRUE(left_image.ok() && right_image.ok());
  const Eigen::Vector2d in_left = Centroid(*left_image);
  const Eigen::Vector2d in_right = Centroid(*right_image);
  EXPECT_LT((in_left - expected).norm(), 0.3);
  EXPECT_NEAR(in_left.y(), in_right.y(), 0.3);
  const double disparity = rectifier->camera().fx * rectifier->baseline_m() / point_in_rectified.z();
  EXPECT_NEAR(in_left.x() - in_right.x(), disparity, 0.3);
}

TEST_F(EurocSource, RectificationPutsAPointWhereThePinholePairSeesIt) {
  MakeRecording();
  const EurocCamera left = ReadEurocCamera(Path("mav0/cam0/sensor.yaml")).value();
  const EurocCamera right = ReadEurocCamera(Path("mav0/cam1/sensor.yaml")).value();
  ExpectRectified(left.intrinsics, right.intrinsics,
                  right.body_from_camera.Inverse() * left.body_from_camera);
}

TEST(StereoRectifier, WorksForFisheyes) {
  CameraIntrinsics camera{512,
                          512,
                          190.98,
                          190.97,
                          254.93,
                          256.9,
                          DistortionModel::kEquidistant,
                          {0.00348, 0.000715, -0.00205, 0.0002, 0}};
  const SE3 right_from_left(Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY())),
                            {-0.1, 0.002, 0.001});
  ExpectRectified(camera, camera, right_from_left);
}

TEST(StereoRectifier, RefusesSwappedAndDifferentCameras) {
  const CameraIntrinsics camera{640, 480, 400, 400, 320, 240, DistortionModel::kNone, {}};
  CameraIntrinsics smaller = camera;
  smaller.width = 320;
  const SE3 right_from_left(Eigen::Quaterniond::Identity(), {-0.1, 0, 0});
  EXPECT_TRUE(StereoRectifier::Create(camera, camera, right_from_left).ok());
  EXPECT_FALSE(StereoRectifier::Create(camera, camera, right_from_left.Inverse()).ok());
  EXPECT_FALSE(StereoRectifier::Create(camera, smaller, right_from_left).ok());
}

}  // namespace
}  // namespace semmap::client
