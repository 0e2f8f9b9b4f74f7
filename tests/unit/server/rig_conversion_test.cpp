#include "server/rig_conversion.h"

#include <cmath>
#include <functional>
#include <limits>

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

constexpr int64_t kMaxPixels = 4'000'000;

v1::CameraRig StereoRig() {
  v1::CameraRig rig;
  rig.set_sensor(v1::SENSOR_TYPE_STEREO);
  v1::CameraIntrinsics* camera = rig.mutable_camera();
  camera->set_width(1226);
  camera->set_height(370);
  camera->set_fx(707);
  camera->set_fy(707);
  camera->set_cx(601);
  camera->set_cy(183);
  camera->set_distortion_model(v1::DISTORTION_MODEL_NONE);
  rig.set_baseline_m(0.54);
  rig.set_frames_per_second(10);
  return rig;
}

TEST(RigConversion, SurvivesARoundTrip) {
  const auto rig = RigFromProto(StereoRig(), kMaxPixels);
  ASSERT_TRUE(rig.ok()) << rig.status();
  EXPECT_EQ(rig->sensor, SensorType::kStereo);
  EXPECT_EQ(rig->baseline_m, 0.54);
  const auto again = RigFromProto(ToProto(*rig), kMaxPixels);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(ToProto(*rig), ToProto(*again)));
}

TEST(RigConversion, KeepsDistortionOfEitherModel) {
  v1::CameraRig proto = StereoRig();
  proto.set_sensor(v1::SENSOR_TYPE_MONO);
  proto.mutable_camera()->set_distortion_model(v1::DISTORTION_MODEL_EQUIDISTANT);
  for (const double k : {0.1, 0.02, 0.003, 0.0004}) proto.mutable_camera()->add_distortion(k);
  const auto rig = RigFromProto(proto, kMaxPixels);
  ASSERT_TRUE(rig.ok()) << rig.status();
  EXPECT_EQ(rig->camera.distortion_model, DistortionModel::kEquidistant);
  EXPECT_EQ(rig->camera.distortion[3], 0.0004);
  EXPECT_EQ(ToProto(*rig).camera().distortion_size(), 4);
}

TEST(RigConversion, IgnoresWhatTheSensorDoesNotHave) {
  v1::CameraRig proto = StereoRig();
  proto.set_sensor(v1::SENSOR_TYPE_MONO);
  proto.set_baseline_m(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(RigFromProto(proto, kMaxPixels).ok());
}

struct BadRig {
  const char* what;
  std::function<void(v1::CameraRig*)> spoil;
  v1::ErrorReason reason = v1::ERROR_REASON_RIG_INVALID;
};

TEST(RigConversion, RefusesWhatIsNoRig) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const BadRig bad[] = {
      {"no sensor", [](auto* rig) { rig->clear_sensor(); }},
      {"no camera", [](auto* rig) { rig->clear_camera(); }},
      {"no model", [](auto* rig) { rig->mutable_camera()->clear_distortion_model(); }},
      {"nan focal length", [&](auto* rig) { rig->mutable_camera()->set_fx(nan); }},
      {"infinite focal length", [&](auto* rig) { rig->mutable_camera()->set_fy(infinity); }},
      {"negative focal length", [](auto* rig) { rig->mutable_camera()->set_fx(-700); }},
      {"nan centre", [&](auto* rig) { rig->mutable_camera()->set_cx(nan); }},
      {"centre outside", [](auto* rig) { rig->mutable_camera()->set_cy(370); }},
      {"no width", [](auto* rig) { rig->mutable_camera()->set_width(0); }},
      {"negative height", [](auto* rig) { rig->mutable_camera()->set_height(-370); }},
      {"stray distortion", [](auto* rig) { rig->mutable_camera()->add_distortion(0.1); }},
      {"nan baseline", [&](auto* rig) { rig->set_baseline_m(nan); }},
      {"no baseline", [](auto* rig) { rig->set_baseline_m(0); }},
      {"nan rate", [&](auto* rig) { rig->set_frames_per_second(nan); }},
      {"no rotation", [](auto* rig) { rig->mutable_body_from_camera()->mutable_translation()->set_x(1); }},
      {"nan body",
       [&](auto* rig) {
         rig->mutable_body_from_camera()->mutable_rotation()->set_w(1);
         rig->mutable_body_from_camera()->mutable_translation()->set_x(nan);
       }},
      {"too many pixels",
       [](auto* rig) {
         rig->mutable_camera()->set_width(8000);
         rig->mutable_camera()->set_height(8000);
       },
       v1::ERROR_REASON_IMAGE_TOO_LARGE},
  };
  for (const BadRig& each : bad) {
    v1::CameraRig rig = StereoRig();
    each.spoil(&rig);
    const auto status = RigFromProto(rig, kMaxPixels).status();
    EXPECT_EQ(ReasonOf(status), each.reason) << each.what << ": " << status;
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << each.what;
  }
}

}  // namespace
}  // namespace semmap::server
