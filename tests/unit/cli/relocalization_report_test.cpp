#include "client/cli/relocalization_report.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace semmap::client {
namespace {

using testing::HasSubstr;
using testing::Not;

v1::RelocalizeResponse Found() {
  v1::RelocalizeResponse response;
  response.set_result(v1::RELOCALIZE_RESULT_FOUND);
  response.set_inliers(120);
  response.set_matches(80);
  response.set_map_version(9);
  response.set_processing_ms(12.34);
  response.add_keyframe_ids(17);
  response.add_keyframe_ids(4);
  response.mutable_map_from_camera()->mutable_translation()->set_x(1.0 / 3);
  response.mutable_map_from_camera()->mutable_rotation()->set_w(1);
  // 1 cm, 2 cm and 2 cm: 3 cm.
  for (int i = 0; i < 21; ++i) response.mutable_covariance()->add_upper_triangle(0);
  response.mutable_covariance()->set_upper_triangle(0, 1e-4);
  response.mutable_covariance()->set_upper_triangle(6, 4e-4);
  response.mutable_covariance()->set_upper_triangle(11, 4e-4);
  return response;
}

TEST(RelocalizationReport, JsonHasAllThatWasAnswered) {
  const nlohmann::json json = RelocalizationJson("a.png", Found());
  EXPECT_EQ(json["image"], "a.png");
  EXPECT_EQ(json["result"], "FOUND");
  EXPECT_EQ(json["position"][0].get<double>(), 1.0 / 3) << "with all digits";
  EXPECT_EQ(json["rotation"], (std::vector<double>{0, 0, 0, 1}));
  EXPECT_NEAR(json["deviation_m"].get<double>(), 0.03, 1e-12);
  EXPECT_EQ(json["keyframes"], (std::vector<uint64_t>{17, 4}));
  EXPECT_EQ(json["map_version"], 9);
  EXPECT_FALSE(json.contains("class_agreement"));
}

TEST(RelocalizationReport, APlaceOnEarthHasItsColumns) {
  v1::RelocalizeResponse response = Found();
  response.mutable_geo_position()->set_latitude_deg(48.137);
  response.mutable_geo_position()->set_longitude_deg(11.575);
  response.mutable_geo_position()->set_altitude_m(519.5);
  const nlohmann::json json = RelocalizationJson("a.png", response);
  EXPECT_EQ(json["latitude_deg"], 48.137);
  EXPECT_EQ(json["longitude_deg"], 11.575);
  EXPECT_EQ(json["altitude_m"], 519.5);
  nlohmann::json all = nlohmann::json::array();
  all.push_back(RelocalizationJson("b.png", Found()));
  EXPECT_THAT(RelocalizationTable(all), Not(HasSubstr("latitude")));
  all.push_back(json);
  EXPECT_THAT(RelocalizationTable(all), HasSubstr("48.13700000"));
  EXPECT_THAT(RelocalizationTable(all), HasSubstr("519.500"));
}

TEST(RelocalizationReport, WhatWasNotFoundHasAReasonAndNoPose) {
  v1::RelocalizeResponse response;
  response.set_result(v1::RELOCALIZE_RESULT_DEGENERATE_POSE);
  response.set_inliers(33);
  response.set_class_agreement(0.75);
  const nlohmann::json json = RelocalizationJson("b.png", response);
  EXPECT_EQ(json["result"], "DEGENERATE_POSE");
  EXPECT_EQ(json["class_agreement"], 0.75);
  EXPECT_FALSE(json.contains("position"));
  EXPECT_FALSE(json.contains("keyframes"));
}

TEST(RelocalizationReport, ARowForEachPicture) {
  nlohmann::json all = nlohmann::json::array();
  all.push_back(RelocalizationJson("a.png", Found()));
  all.push_back(RelocalizationJson("b.png", v1::RelocalizeResponse()));
  const std::string table = RelocalizationTable(all);
  EXPECT_THAT(table, HasSubstr("0.333"));
  EXPECT_THAT(table, HasSubstr("0.030"));
  EXPECT_THAT(table, HasSubstr("17"));
  EXPECT_THAT(table, HasSubstr("UNSPECIFIED"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 3);
}

}  // namespace
}  // namespace semmap::client
