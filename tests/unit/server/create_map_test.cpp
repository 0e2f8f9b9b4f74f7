#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

using CreateMapTest = HandlerTest;

v1::CreateMapRequest RequestFor(const std::string& name, const std::string& request_id = "") {
  v1::CreateMapRequest request;
  request.mutable_map()->set_name(name);
  request.set_request_id(request_id);
  return request;
}

TEST_F(CreateMapTest, MakesAnEmptyMap) {
  const auto map = CreateMap(context_, RequestFor("maps/town"));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->name(), "maps/town");
  EXPECT_EQ(map->state(), v1::MAP_STATE_EMPTY);
  EXPECT_EQ(map->create_time().seconds(), 1'700'000'000);
  EXPECT_FALSE(map->etag().empty());
}

TEST_F(CreateMapTest, ATakenNameIsRefusedARepeatedRequestIsNot) {
  ASSERT_TRUE(CreateMap(context_, RequestFor("maps/town", "r1")).ok());
  EXPECT_TRUE(CreateMap(context_, RequestFor("maps/town", "r1")).ok());
  EXPECT_EQ(ReasonOf(CreateMap(context_, RequestFor("maps/town", "r2")).status()),
            v1::ERROR_REASON_MAP_EXISTS);
}

TEST_F(CreateMapTest, KeepsWhatIsSaidAboutIt) {
  v1::CreateMapRequest request = RequestFor("maps/town");
  request.mutable_map()->set_display_name("Town");
  (*request.mutable_map()->mutable_labels())["owner"] = "fleet";
  const auto map = CreateMap(context_, request);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->display_name(), "Town");
  // Also when a session begins the empty map anew.
  ASSERT_NE(OpenSession("town"), nullptr);
  EXPECT_EQ(store_->GetMap("town")->display_name, "Town");
  EXPECT_EQ(store_->GetMap("town")->labels.at("owner"), "fleet");
}

TEST_F(CreateMapTest, RefusesBadNamesAndFields) {
  EXPECT_EQ(ReasonOf(CreateMap(context_, RequestFor("town")).status()), v1::ERROR_REASON_NAME_INVALID);
  v1::CreateMapRequest request = RequestFor("maps/town");
  request.mutable_map()->set_display_name(std::string(257, 'x'));
  EXPECT_EQ(ReasonOf(CreateMap(context_, request).status()), v1::ERROR_REASON_FIELD_INVALID);
}

TEST_F(CreateMapTest, ASessionTakesTheEmptyMapOver) {
  ASSERT_TRUE(CreateMap(context_, RequestFor("maps/town")).ok());
  ASSERT_NE(OpenSession("town"), nullptr);
  const auto map = store_->GetMap("town");
  ASSERT_TRUE(map.ok());
  EXPECT_EQ(map->rig.camera.width, 64);
  EXPECT_FALSE(map->scale_known);
  EXPECT_EQ(map->created_at, 1'700'000'000'000'000'000);
}

}  // namespace
}  // namespace semmap::server
