#include "client/sources/euroc_calibration.h"

#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "yaml-cpp/yaml.h"

namespace semmap::client {
namespace {

absl::Status BadKey(const std::string& path, const char* key, const char* reason) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", key, " ", reason));
}

// A list of finite numbers; empty when it is not.
std::vector<double> NumbersOf(const YAML::Node& node) {
  std::vector<double> numbers;
  if (!node.IsDefined() || !YAML::convert<std::vector<double>>::decode(node, numbers)) return {};
  for (const double number : numbers) {
    if (!std::isfinite(number)) return {};
  }
  return numbers;
}

absl::Status ReadDistortion(const std::string& path, const YAML::Node& root, CameraIntrinsics* camera) {
  const auto model = root["distortion_model"].as<std::string>("none");
  const std::vector<double> coefficients = NumbersOf(root["distortion_coefficients"]);
  if (model == "none") return absl::OkStatus();
  if (model == "radial-tangential" || model == "radtan") {
    camera->distortion_model = DistortionModel::kRadialTangential;
  } else if (model == "equidistant") {
    camera->distortion_model = DistortionModel::kEquidistant;
  } else {
    return BadKey(path, "distortion_model", "must be radial-tangential, equidistant or none");
  }
  if (coefficients.size() != 4) return BadKey(path, "distortion_coefficients", "must be 4 numbers");
  std::copy(coefficients.begin(), coefficients.end(), camera->distortion.begin());
  return absl::OkStatus();
}

absl::StatusOr<EurocCamera> Parse(const std::string& path, const YAML::Node& root) {
  if (!root.IsMap()) return absl::InvalidArgumentError(absl::StrCat(path, ": expected a mapping"));
  EurocCamera camera;
  const std::vector<double> size = NumbersOf(root["resolution"]);
  const std::vector<double> pinhole = NumbersOf(root["intrinsics"]);
  if (size.size() != 2 || size[0] < 1 || size[1] < 1 || size[0] > 16384 || size[1] > 16384) {
    return BadKey(path, "resolution", "must be width and height");
  }
  if (pinhole.size() != 4) return BadKey(path, "intrinsics", "must be fu, fv, cu, cv");
  camera.intrinsics.width = static_cast<int>(size[0]);
  camera.intrinsics.height = static_cast<int>(size[1]);
  camera.intrinsics.fx = pinhole[0];
  camera.intrinsics.fy = pinhole[1];
  camera.intrinsics.cx = pinhole[2];
  camera.intrinsics.cy = pinhole[3];
  SEMMAP_RETURN_IF_ERROR(ReadDistortion(path, root, &camera.intrinsics));
  const std::vector<double> pose = NumbersOf(root["T_BS"] ? root["T_BS"]["data"] : YAML::Node());
  if (pose.size() != 16) return BadKey(path, "T_BS", "must hold the 16 numbers of a 4x4 matrix");
  camera.body_from_camera =
      SE3::FromMatrix(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(pose.data()));
  camera.frames_per_second = root["rate_hz"].as<double>(camera.frames_per_second);
  return camera;
}

}  // namespace

absl::StatusOr<EurocCamera> ReadEurocCamera(const std::string& path) {
  try {
    const YAML::Node root = YAML::LoadFile(path);
    return Parse(path, root);
  } catch (const YAML::BadFile&) {
    return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  } catch (const YAML::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(path, ":", error.mark.line + 1, ": ", error.msg));
  }
}

}  // namespace semmap::client
