#include "client/sources/camera_file.h"

#include <gmock/gmock.h>

#include "tests/unit/sources/source_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

class CameraFile : public SourceTest {
 protected:
  absl::StatusOr<CameraRig> Read(const std::string& text, SensorType sensor = SensorType::kMono) {
    WriteText("camera.yaml", text);
    return ReadCameraFile(Path("camera.yaml"), sensor);
  }
  void ExpectComplaint(const std::string& text, const char* complaint,
                       SensorType sensor = SensorType::kMono) {
    const auto rig = Read(text, sensor);
    ASSERT_FALSE(rig.ok()) << text;
    EXPECT_EQ(rig.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(rig.status().message()), HasSubstr(complaint));
  }
};

TEST_F(CameraFile, ReadsEverything) {
  const auto rig = Read(std::string(kSmallCamera) +
                            "distortion_model: radial_tangential\ndistortion: [0.1, 0.2, 0.3, 0.4, 0.5]\n"
                            "depth_units_per_metre: 5000\nframes_per_second: 30\n"
                            "body_from_camera: [0, 0, 1, 4, -1, 0, 0, 5, 0, -1, 0, 6, 0, 0, 0, 1]\n",
                        SensorType::kRgbd);
  ASSERT_TRUE(rig.ok()) << rig.status();
  EXPECT_EQ(rig->camera.width, 64);
  EXPECT_DOUBLE_EQ(rig->camera.cy, 24);
  EXPECT_EQ(rig->camera.distortion_model, DistortionModel::kRadialTangential);
  EXPECT_DOUBLE_EQ(rig->camera.distortion[4], 0.5);
  EXPECT_DOUBLE_EQ(rig->depth_units_per_metre, 5000);
  EXPECT_DOUBLE_EQ(rig->frames_per_second, 30);
  EXPECT_TRUE((rig->body_from_camera * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(4, 4, 6)));
}

TEST_F(CameraFile, NamesWhatIsWrong) {
  const std::string good = kSmallCamera;
  ExpectComplaint("width: 64\n", "height is missing");
  ExpectComplaint(good + "focal: 3\n", "camera.yaml:7: focal is not a known key");
  ExpectComplaint(good + "frames_per_second: .nan\n", "frames_per_second");
  ExpectComplaint(good + "distortion: [1, 2, 3, 4]\n", "needs a distortion_model");
  ExpectComplaint(good + "distortion_model: equidistant\ndistortion: [1, 2, 3]\n", "must be k1, k2, k3, k4");
  ExpectComplaint(good + "body_from_camera: [1, 2]\n", "16 numbers");
  ExpectComplaint(good + "body_from_camera: [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n", "not a rigid motion");
  ExpectComplaint(good, "baseline_m is missing", SensorType::kStereo);
  ExpectComplaint(good + "baseline_m: -1\n", "baseline_m", SensorType::kStereo);
  EXPECT_EQ(ReadCameraFile(Path("none.yaml"), SensorType::kMono).status().code(),
            absl::StatusCode::kNotFound);
}

TEST(CameraFiles, TheExamplesAreValid) {
  const std::string folder = std::string(SEMMAP_SOURCE_DIR) + "/config/cameras/";
  EXPECT_TRUE(ReadCameraFile(folder + "kitti00.yaml", SensorType::kStereo).ok());
  EXPECT_TRUE(ReadCameraFile(folder + "tum_freiburg1.yaml", SensorType::kRgbd).ok());
  EXPECT_TRUE(ReadCameraFile(folder + "euroc_cam0.yaml", SensorType::kMono).ok());
  EXPECT_TRUE(ReadCameraFile(folder + "fisheye_example.yaml", SensorType::kMono).ok());
}

}  // namespace
}  // namespace semmap::client
