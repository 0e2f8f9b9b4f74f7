#include <limits>
#include <numbers>

#include "handler_fixture.h"
#include "server/handlers/localization_handlers.h"
#include "server/map_cache.h"

namespace semmap::server {
namespace {

class RelocalizeTest : public HandlerTest {
 protected:
  RelocalizeTest() {
    MakeMap("town", "s1", 30);
    request_.set_map("maps/town");
    v1::CameraIntrinsics* camera = request_.mutable_rig()->mutable_camera();
    request_.mutable_rig()->set_sensor(v1::SENSOR_TYPE_MONO);
    camera->set_width(64);
    camera->set_height(48);
    camera->set_fx(50);
    camera->set_fy(50);
    camera->set_cx(32);
    camera->set_cy(24);
    camera->set_distortion_model(v1::DISTORTION_MODEL_NONE);
    v1::Image* image = request_.mutable_frame()->mutable_image();
    image->set_encoding(v1::IMAGE_ENCODING_RAW_GRAY8);
    image->set_width(64);
    image->set_height(48);
    image->set_data(std::string(64 * 48, '\x40'));
  }

  v1::ErrorReason Refusal() { return ReasonOf(PrepareRelocalize(context_, request_).status()); }

  v1::RelocalizeRequest request_;
};

TEST_F(RelocalizeTest, WhatIsAskedForIsRead) {
  v1::PosePrior* prior = request_.mutable_prior();
  prior->mutable_position_in_map()->set_x(3);
  prior->set_radius_m(2);
  prior->mutable_heading_in_map()->set_z(5);
  prior->set_heading_tolerance_rad(0.5);
  const auto task = PrepareRelocalize(context_, request_);
  ASSERT_TRUE(task.ok()) << task.status();
  EXPECT_EQ(task->map.name, "town");
  EXPECT_EQ(task->rig.camera.width, 64);
  EXPECT_EQ(task->prior.position->in_map, Eigen::Vector3d(3, 0, 0));
  EXPECT_EQ(task->prior.position->radius, 2);
  EXPECT_EQ(task->prior.heading->in_map, Eigen::Vector3d(0, 0, 1)) << "of unit length";
  EXPECT_EQ(task->prior.heading->tolerance, 0.5);
}

TEST_F(RelocalizeTest, WhatIsWrongIsRefused) {
  request_.set_map("maps/nowhere");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_NOT_FOUND);
  request_.set_map("town");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_NAME_INVALID);
  ASSERT_TRUE(store_->CreateMap({"empty", 1, SmallRig(), false}).ok());
  request_.set_map("maps/empty");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_EMPTY);
  request_.set_map("maps/town");
  *request_.mutable_frame()->mutable_right() = request_.frame().image();
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_IMAGE_UNEXPECTED);
  request_.mutable_frame()->clear_right();
  request_.mutable_frame()->clear_image();
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_IMAGE_MISSING);
}

TEST_F(RelocalizeTest, APriorThatSaysNothingIsRefused) {
  v1::PosePrior* prior = request_.mutable_prior();
  prior->mutable_position_in_map();
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID) << "no radius";
  prior->set_radius_m(std::numeric_limits<double>::infinity());
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  prior->set_radius_m(1);
  prior->mutable_heading_in_map();
  prior->set_heading_tolerance_rad(1);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID) << "no direction";
  prior->mutable_heading_in_map()->set_x(1);
  prior->set_heading_tolerance_rad(std::numbers::pi + 0.01);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  prior->set_heading_tolerance_rad(std::numbers::pi);
  EXPECT_TRUE(PrepareRelocalize(context_, request_).ok());
}

TEST_F(RelocalizeTest, APlaceOnEarthIsOneInTheMap) {
  v1::PosePrior* prior = request_.mutable_prior();
  prior->mutable_geo_position()->set_latitude_deg(48);
  prior->mutable_geo_position()->set_longitude_deg(11);
  prior->set_radius_m(20);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_NOT_ANCHORED);
  // East is the map's z, up its -y; a unit of the map is two metres.
  storage::GeoAnchor anchor;
  anchor.latitude_deg = 48;
  anchor.longitude_deg = 11;
  anchor.altitude_m = 500;
  Eigen::Matrix3d enu_from_map;
  enu_from_map << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  anchor.enu_from_map = {2, SE3(Eigen::Quaterniond(enu_from_map), {10, 0, 0})};
  ASSERT_TRUE(store_->SetAnchor(store_->GetMap("town")->id, anchor).ok());
  auto task = PrepareRelocalize(context_, request_);
  ASSERT_TRUE(task.ok()) << task.status();
  EXPECT_EQ(task->prior.position->radius, 10);
  EXPECT_LT((task->prior.position->up_in_map - Eigen::Vector3d(0, -1, 0)).norm(), 1e-9);
  // Ten metres west of the map's origin, whose height is not known.
  const auto admits = [&](const Eigen::Vector3d& in_map) {
    return task->prior.Admits(SE3(Eigen::Quaterniond::Identity(), in_map));
  };
  EXPECT_TRUE(admits({0, 300, -5}));
  EXPECT_TRUE(admits({0, 0, 4.9}));
  EXPECT_FALSE(admits({0, 0, 5.1}));
  prior->mutable_geo_position()->set_altitude_m(500);
  task = PrepareRelocalize(context_, request_);
  ASSERT_TRUE(task.ok()) << task.status();
  EXPECT_LT((task->prior.position->in_map - Eigen::Vector3d(0, 0, -5)).norm(), 1e-6);
  EXPECT_FALSE(admits({0, 300, -5}));
}

TEST_F(RelocalizeTest, NoPlaceOnEarthIsRefused) {
  v1::PosePrior* prior = request_.mutable_prior();
  prior->mutable_geo_position()->set_latitude_deg(91);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID) << "no radius";
  prior->set_radius_m(20);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID) << "beyond the pole";
  prior->mutable_geo_position()->set_latitude_deg(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  prior->mutable_geo_position()->set_latitude_deg(48);
  prior->mutable_position_in_map();
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID) << "two positions";
}

TEST_F(RelocalizeTest, AnImageWithoutFeaturesIsAnAnswer) {
  const auto task = PrepareRelocalize(context_, request_);
  ASSERT_TRUE(task.ok()) << task.status();
  const auto map = MakeMapLoader(store_.get(), context_.slam, nullptr)(task->map.id, size_t{1} << 30);
  ASSERT_TRUE(map.ok()) << map.status();
  const auto response = Relocalize(context_, request_, *task, **map);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->result(), v1::RELOCALIZE_RESULT_TOO_FEW_FEATURES);
  EXPECT_EQ(response->map_version(), task->map.version);
  EXPECT_FALSE(response->has_map_from_camera());
  request_.mutable_frame()->mutable_image()->mutable_data()->pop_back();
  EXPECT_EQ(ReasonOf(Relocalize(context_, request_, *task, **map).status()), v1::ERROR_REASON_IMAGE_CORRUPT);
}

}  // namespace
}  // namespace semmap::server
