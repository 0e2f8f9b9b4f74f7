#include "client/sources/camera_file.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/common/config_reader.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

constexpr int kMaxImageSide = 16384;
constexpr double kMaxPixels = 1e6;
constexpr double kRotationTolerance = 1e-3;

void Require(const char* key, ConfigReader& reader) {
  if (!reader.Has(key)) reader.Complain(key, "is missing");
}

void ReadPinhole(ConfigReader& reader, CameraIntrinsics* camera) {
  for (const char* key : {"width", "height", "fx", "fy", "cx", "cy"}) Require(key, reader);
  reader.Number("width", &camera->width, 1, kMaxImageSide);
  reader.Number("height", &camera->height, 1, kMaxImageSide);
  reader.Number("fx", &camera->fx, 1.0, kMaxPixels);
  reader.Number("fy", &camera->fy, 1.0, kMaxPixels);
  reader.Number("cx", &camera->cx, -kMaxPixels, kMaxPixels);
  reader.Number("cy", &camera->cy, -kMaxPixels, kMaxPixels);
}

void ReadDistortion(ConfigReader& reader, CameraIntrinsics* camera) {
  std::string model = "none";
  reader.Choice("distortion_model", &model, {"none", "radial_tangential", "equidistant"});
  std::vector<double> coefficients;
  reader.NumberList("distortion", &coefficients, camera->distortion.size());
  const size_t count = coefficients.size();
  if (model == "none" && count != 0) reader.Complain("distortion", "needs a distortion_model");
  if (model == "radial_tangential" && count != 4 && count != 5) {
    reader.Complain("distortion", "must be k1, k2, p1, p2 and perhaps k3");
  }
  if (model == "equidistant" && count != 4) reader.Complain("distortion", "must be k1, k2, k3, k4");
  if (model == "radial_tangential") camera->distortion_model = DistortionModel::kRadialTangential;
  if (model == "equidistant") camera->distortion_model = DistortionModel::kEquidistant;
  std::copy(coefficients.begin(), coefficients.end(), camera->distortion.begin());
}

void ReadBodyFromCamera(ConfigReader& reader, SE3* body_from_camera) {
  std::vector<double> numbers;
  reader.NumberList("body_from_camera", &numbers, 16);
  if (numbers.empty()) return;
  if (numbers.size() != 16) {
    reader.Complain("body_from_camera", "must be the 16 numbers of a 4x4 matrix, row by row");
    return;
  }
  const Eigen::Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const bool is_rigid = error < kRotationTolerance && rotation.determinant() > 0 &&
                        matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1)) && matrix.allFinite();
  if (!is_rigid) {
    reader.Complain("body_from_camera", "is not a rigid motion");
    return;
  }
  *body_from_camera = SE3::FromMatrix(matrix);
}

}  // namespace

absl::StatusOr<CameraRig> ReadCameraFile(const std::string& path, SensorType sensor) {
  SEMMAP_ASSIGN_OR_RETURN(ConfigReader reader, ConfigReader::FromFile(path));
  CameraRig rig;
  rig.sensor = sensor;
  ReadPinhole(reader, &rig.camera);
  ReadDistortion(reader, &rig.camera);
  if (sensor == SensorType::kStereo) Require("baseline_m", reader);
  reader.Number("baseline_m", &rig.baseline_m, 1e-4, 100.0);
  reader.Number("depth_units_per_metre", &rig.depth_units_per_metre, 1e-3, 1e6);
  reader.Number("frames_per_second", &rig.frames_per_second, 0.01, 1000.0);
  ReadBodyFromCamera(reader, &rig.body_from_camera);
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  const absl::Status valid = ValidateRig(rig);
  if (!valid.ok()) return absl::Status(valid.code(), absl::StrCat(path, ": ", valid.message()));
  return rig;
}

}  // namespace semmap::client
