#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

class UpdateMapTest : public HandlerTest {
 protected:
  UpdateMapTest() {
    MakeMap("town", "s1", 12);
    request_.mutable_map()->set_name("maps/town");
  }

  void SetAnchor() {
    v1::GeoAnchor* anchor = request_.mutable_map()->mutable_anchor();
    anchor->mutable_origin()->set_latitude_deg(48);
    anchor->mutable_enu_from_map()->mutable_pose()->mutable_rotation()->set_w(1);
    request_.mutable_update_mask()->add_paths("anchor");
  }

  v1::Map Update() {
    const auto map = UpdateMap(context_, request_);
    EXPECT_TRUE(map.ok()) << map.status();
    return map.value_or(v1::Map());
  }
  v1::ErrorReason Refusal() { return ReasonOf(UpdateMap(context_, request_).status()); }

  v1::UpdateMapRequest request_;
};

TEST_F(UpdateMapTest, OnlyTheFieldsNamedChange) {
  request_.mutable_map()->set_display_name("Town");
  (*request_.mutable_map()->mutable_labels())["a"] = "b";
  request_.mutable_update_mask()->add_paths("display_name");
  const v1::Map map = Update();
  EXPECT_EQ(map.display_name(), "Town");
  EXPECT_EQ(map.labels_size(), 0);
  EXPECT_EQ(map.keyframe_count(), 3);
  request_.mutable_map()->clear_display_name();
  request_.mutable_update_mask()->set_paths(0, "labels");
  EXPECT_EQ(Update().labels().at("a"), "b");
  EXPECT_EQ(GetMap(context_,
                   [] {
                     v1::GetMapRequest r;
                     r.set_name("maps/town");
                     return r;
                   }())
                ->display_name(),
            "Town");
}

TEST_F(UpdateMapTest, AnchorsComeAndGo) {
  SetAnchor();
  const v1::Map map = Update();
  EXPECT_EQ(map.anchor().origin().latitude_deg(), 48);
  EXPECT_EQ(map.anchor().enu_from_map().scale(), 1);
  EXPECT_EQ(map.anchor().source(), v1::GeoAnchor::SOURCE_MANUAL);
  request_.mutable_map()->clear_anchor();
  EXPECT_FALSE(Update().has_anchor());
}

TEST_F(UpdateMapTest, TheEtagTellsOfEveryChange) {
  SetAnchor();
  const std::string first = Update().etag();
  request_.mutable_map()->set_etag(first);
  const std::string second = Update().etag();
  EXPECT_NE(first, second);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_ETAG_MISMATCH);
}

TEST_F(UpdateMapTest, ARepeatedRequestAnswersTheSame) {
  SetAnchor();
  request_.set_request_id("r");
  const std::string etag = Update().etag();
  EXPECT_EQ(Update().etag(), etag);
}

TEST_F(UpdateMapTest, Refusals) {
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID) << "no mask";
  request_.mutable_update_mask()->add_paths("version");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.clear_update_mask();
  SetAnchor();
  request_.mutable_map()->mutable_anchor()->mutable_origin()->set_latitude_deg(91);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.mutable_map()->mutable_anchor()->mutable_origin()->set_latitude_deg(1);
  request_.mutable_map()->mutable_anchor()->mutable_enu_from_map()->set_scale(-1);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.mutable_map()->mutable_anchor()->clear_enu_from_map();
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.mutable_map()->clear_anchor();
  request_.mutable_update_mask()->add_paths("labels");
  (*request_.mutable_map()->mutable_labels())[std::string(64, 'k')] = "v";
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  request_.mutable_map()->clear_labels();
  request_.mutable_map()->set_name("maps/nowhere");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_NOT_FOUND);
}

}  // namespace
}  // namespace semmap::server
