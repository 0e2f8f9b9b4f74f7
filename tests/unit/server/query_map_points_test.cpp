#include <cmath>
#include <numbers>

#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

// Points lie at x = 1, 6, 11 ...; z = 10; ids 1, 2, 3 ...; odd ones are of class 10, even ones of class 1.
class QueryMapPointsTest : public HandlerTest {
 protected:
  QueryMapPointsTest() {
    MakeMap("town", "s1", 50);
    request_.set_map("maps/town");
  }

  std::vector<uint64_t> Ids() {
    std::vector<uint64_t> ids;
    auto source = QueryMapPoints(context_, request_);
    EXPECT_TRUE(source.ok()) << source.status();
    if (!source.ok()) return ids;
    v1::QueryMapPointsResponse response;
    while (true) {
      response.Clear();
      const auto more = (*source)->Next(&response);
      EXPECT_TRUE(more.ok()) << more.status();
      if (!more.ok() || !*more) return ids;
      ++messages_;
      last_ = response;
      ids.insert(ids.end(), response.points().ids().begin(), response.points().ids().end());
    }
  }
  v1::ErrorReason Refusal() { return ReasonOf(QueryMapPoints(context_, request_).status()); }

  v1::QueryMapPointsRequest request_;
  int messages_ = 0;
  v1::QueryMapPointsResponse last_;
};

TEST_F(QueryMapPointsTest, SendsAllInPieces) {
  context_.config.query_chunk = 3;
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
  EXPECT_EQ(messages_, 4);
  EXPECT_EQ(last_.points().positions_size(), 3);
  EXPECT_EQ(last_.points().positions(0), 46);
  EXPECT_EQ(last_.points().semantic_classes(0), 1U);
  EXPECT_EQ(last_.points().first_seen_ns(0), 4600);
  EXPECT_EQ(last_.points().normals(2), 1);
  EXPECT_EQ(last_.map_version(), 10U);
}

TEST_F(QueryMapPointsTest, ALimitEndsIt) {
  context_.config.query_chunk = 3;
  request_.set_limit(4);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{1, 2, 3, 4}));
  request_.set_limit(3);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{1, 2, 3}));
}

TEST_F(QueryMapPointsTest, FiltersByPlaceClassAndTime) {
  v1::MapPointFilter* filter = request_.mutable_filter();
  filter->mutable_area()->mutable_box()->mutable_min()->set_x(6);
  filter->mutable_area()->mutable_box()->mutable_max()->set_x(16);
  filter->mutable_area()->mutable_box()->mutable_max()->set_z(10);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{2, 3, 4}));
  filter->add_semantic_classes(1);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{2, 4}));
  filter->mutable_seen()->set_start_ns(700);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{4}));
  filter->Clear();
  filter->set_active_only(true);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{2, 4, 6, 8, 10}));
  filter->mutable_area()->mutable_sphere()->mutable_center()->set_x(20);
  filter->mutable_area()->mutable_sphere()->mutable_center()->set_z(10);
  filter->mutable_area()->mutable_sphere()->set_radius_m(5);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{4}));
}

TEST_F(QueryMapPointsTest, TheNearestOfWhatPassesTheFilter) {
  v1::MapPointFilter* filter = request_.mutable_filter();
  filter->mutable_area()->mutable_nearest()->mutable_point()->set_x(17);
  filter->mutable_area()->mutable_nearest()->mutable_point()->set_z(10);
  filter->mutable_area()->mutable_nearest()->set_count(3);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{3, 4, 5}));  // at 11, 16 and 21
  filter->add_semantic_classes(10);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{3, 5, 7}));
  // More than the first boxes hold, and more than there are.
  filter->mutable_area()->mutable_nearest()->mutable_point()->set_x(-5000);
  filter->mutable_area()->mutable_nearest()->set_count(2);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{1, 3}));
  filter->mutable_area()->mutable_nearest()->set_count(1000);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{1, 3, 5, 7, 9}));
}

TEST_F(QueryMapPointsTest, PositionsOnEarth) {
  request_.set_coordinates(v1::COORDINATES_WGS84);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_NOT_ANCHORED);
  // The map's z points north, its x east.
  storage::GeoAnchor anchor{48, 11, 500, {}};
  anchor.enu_from_map.rigid =
      SE3(Eigen::Quaterniond(Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX())), {0, 0, 0});
  ASSERT_TRUE(store_->SetAnchor(store_->GetMap("town")->id, anchor).ok());
  request_.set_limit(1);
  EXPECT_EQ(Ids(), std::vector<uint64_t>{1});
  // One metre east and ten north of the origin: metres of a degree at 48 degrees from the WGS84 ellipsoid.
  EXPECT_NEAR((last_.points().positions(0) - 11) * 74'630, 1, 0.01);
  EXPECT_NEAR((last_.points().positions(1) - 48) * 111'200, 10, 0.01);
  EXPECT_NEAR(last_.points().positions(2), 500, 0.001);
}

TEST_F(QueryMapPointsTest, SendsOnlyTheColumnsAskedFor) {
  request_.mutable_columns()->add_paths("observation_counts");
  EXPECT_EQ(Ids().size(), 10U);
  EXPECT_EQ(last_.points().observation_counts_size(), 10);
  EXPECT_EQ(last_.points().positions_size(), 30);
  EXPECT_EQ(last_.points().normals_size(), 0);
}

TEST_F(QueryMapPointsTest, RefusesBadFilters) {
  request_.mutable_filter()->set_min_class_confidence(std::nan(""));
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.mutable_filter()->Clear();
  request_.mutable_filter()->add_semantic_classes(256);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.mutable_filter()->Clear();
  request_.mutable_columns()->add_paths("colour");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.clear_columns();
  request_.set_limit(-1);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.set_limit(0);
  request_.set_map("maps/nowhere");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_NOT_FOUND);
}

}  // namespace
}  // namespace semmap::server
