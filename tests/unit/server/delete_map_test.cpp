#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"

namespace semmap::server {
namespace {

using DeleteMapTest = HandlerTest;

v1::DeleteMapRequest RequestFor(const std::string& name) {
  v1::DeleteMapRequest request;
  request.set_name(name);
  return request;
}

TEST_F(DeleteMapTest, TheMapIsGone) {
  MakeMap("town", "s1", 12);
  EXPECT_TRUE(DeleteMap(context_, RequestFor("maps/town")).ok());
  EXPECT_FALSE(store_->GetMap("town").ok());
  EXPECT_EQ(ReasonOf(DeleteMap(context_, RequestFor("maps/town")).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
}

TEST_F(DeleteMapTest, ARepeatedRequestAndAMissingMapMayBeFine) {
  MakeMap("town", "s1", 1);
  v1::DeleteMapRequest request = RequestFor("maps/town");
  request.set_request_id("r1");
  EXPECT_TRUE(DeleteMap(context_, request).ok());
  EXPECT_TRUE(DeleteMap(context_, request).ok());
  v1::DeleteMapRequest missing = RequestFor("maps/nowhere");
  missing.set_allow_missing(true);
  EXPECT_TRUE(DeleteMap(context_, missing).ok());
}

TEST_F(DeleteMapTest, AMapThatChangedIsKept) {
  MakeMap("town", "s1", 1);
  v1::DeleteMapRequest request = RequestFor("maps/town");
  request.set_etag("of yesterday");
  EXPECT_EQ(ReasonOf(DeleteMap(context_, request).status()), v1::ERROR_REASON_ETAG_MISMATCH);
  request.set_etag(EtagOf(*store_->GetMap("town")));
  EXPECT_TRUE(DeleteMap(context_, request).ok());
}

TEST_F(DeleteMapTest, AMapInUseIsKept) {
  ASSERT_NE(OpenSession("town"), nullptr);
  EXPECT_EQ(ReasonOf(DeleteMap(context_, RequestFor("maps/town")).status()), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_TRUE(store_->GetMap("town").ok());
}

}  // namespace
}  // namespace semmap::server
