#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

// Keyframes are frames 1, 6, 11 ... with ids 1, 2, 3 ...
class QueryKeyFramesTest : public HandlerTest {
 protected:
  QueryKeyFramesTest() {
    MakeMap("town", "s1", 50);
    request_.set_map("maps/town");
  }

  std::vector<uint64_t> Ids() {
    std::vector<uint64_t> ids;
    request_.clear_page_token();
    do {
      const auto response = QueryKeyFrames(context_, request_);
      EXPECT_TRUE(response.ok()) << response.status();
      if (!response.ok()) return ids;
      for (const v1::KeyFrame& keyframe : response->keyframes()) ids.push_back(keyframe.id());
      if (response->keyframes_size() > 0) last_ = *response->keyframes().rbegin();
      request_.set_page_token(response->next_page_token());
    } while (!request_.page_token().empty());
    return ids;
  }

  v1::QueryKeyFramesRequest request_;
  v1::KeyFrame last_;
};

TEST_F(QueryKeyFramesTest, GivesEveryKeyFrameOnceInPages) {
  request_.set_page_size(3);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
  EXPECT_EQ(last_.session(), "sessions/s1");
  EXPECT_EQ(last_.sequence(), 46U);
  EXPECT_EQ(last_.timestamp_ns(), 4600);
  EXPECT_EQ(last_.map_from_camera().translation().x(), 46);
  EXPECT_EQ(last_.parent_id(), 9U);
  EXPECT_EQ(last_.keypoint_count(), 2);
  EXPECT_EQ(last_.observation_count(), 1);
}

TEST_F(QueryKeyFramesTest, FiltersByPlaceTimeAndSession) {
  request_.mutable_area()->mutable_sphere()->mutable_center()->set_x(11);
  request_.mutable_area()->mutable_sphere()->set_radius_m(5.5);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{2, 3, 4}));
  request_.mutable_time()->set_start_ns(1000);
  request_.set_session("sessions/s1");
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{3, 4}));
  request_.set_session("sessions/other");
  EXPECT_EQ(ReasonOf(QueryKeyFrames(context_, request_).status()), v1::ERROR_REASON_SESSION_NOT_FOUND);
}

TEST_F(QueryKeyFramesTest, TheNearestInPages) {
  request_.mutable_area()->mutable_nearest()->mutable_point()->set_x(20);
  request_.mutable_area()->mutable_nearest()->set_count(3);
  request_.set_page_size(2);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{4, 5, 6}));  // at 16, 21 and 26
  request_.mutable_time()->set_end_ns(2100);
  EXPECT_EQ(Ids(), (std::vector<uint64_t>{2, 3, 4}));
}

TEST_F(QueryKeyFramesTest, ATokenBelongsToItsRequest) {
  request_.set_page_size(3);
  const auto first = QueryKeyFrames(context_, request_);
  ASSERT_TRUE(first.ok());
  request_.set_page_token(first->next_page_token());
  request_.mutable_time()->set_start_ns(0);
  EXPECT_EQ(ReasonOf(QueryKeyFrames(context_, request_).status()), v1::ERROR_REASON_PAGE_TOKEN_INVALID);
}

}  // namespace
}  // namespace semmap::server
