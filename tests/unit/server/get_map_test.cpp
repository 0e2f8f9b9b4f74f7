#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

using GetMapTest = HandlerTest;

TEST_F(GetMapTest, TellsWhatTheMapHolds) {
  MakeMap("town", "s1", 12);
  v1::GetMapRequest request;
  request.set_name("maps/town");
  const auto map = GetMap(context_, request);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->keyframe_count(), 3);
  EXPECT_EQ(map->point_count(), 3);
  EXPECT_EQ(map->state(), v1::MAP_STATE_READY);
  EXPECT_EQ(map->version(), 3U);  // one delta a keyframe; frames alone change no map
}

TEST_F(GetMapTest, NoSuchMap) {
  v1::GetMapRequest request;
  request.set_name("maps/nowhere");
  EXPECT_EQ(ReasonOf(GetMap(context_, request).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
  request.set_name("nowhere");
  EXPECT_EQ(ReasonOf(GetMap(context_, request).status()), v1::ERROR_REASON_NAME_INVALID);
}

}  // namespace
}  // namespace semmap::server
