#include "handler_fixture.h"
#include "server/handlers/session_handlers.h"

namespace semmap::server {
namespace {

using GetSessionTest = HandlerTest;

v1::GetSessionRequest RequestFor(const std::string& name) {
  v1::GetSessionRequest request;
  request.set_name(name);
  return request;
}

TEST_F(GetSessionTest, FromTheStore) {
  MakeMap("town", "s1", 12);
  const auto session = GetSession(context_, RequestFor("sessions/s1"));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->map(), "maps/town");
  EXPECT_EQ(session->vehicle_id(), "car");
  EXPECT_EQ(session->state(), v1::SESSION_STATE_FINISHED);
  EXPECT_EQ(session->statistics().frames_received(), 12U);
  EXPECT_EQ(session->last_acknowledged_sequence(), 12U);
}

TEST_F(GetSessionTest, WhileItRuns) {
  const auto running = OpenSession("town");
  ASSERT_NE(running, nullptr);
  const auto session = GetSession(context_, RequestFor("sessions/" + running->identity().id));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->state(), v1::SESSION_STATE_INTERRUPTED);
  EXPECT_EQ(session->mode(), v1::SESSION_MODE_MAP);
}

TEST_F(GetSessionTest, CutOffByACrash) {
  const auto map = store_->CreateMap({"town", 1, SmallRig(), false});
  ASSERT_TRUE(store_->StartSession({map->id, "s1", "car", 1, SmallRig()}).ok());
  const auto session = GetSession(context_, RequestFor("sessions/s1"));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->state(), v1::SESSION_STATE_ABANDONED);
  EXPECT_EQ(session->end_reason(), v1::SESSION_END_REASON_CRASH);
}

TEST_F(GetSessionTest, NoSuchSession) {
  EXPECT_EQ(ReasonOf(GetSession(context_, RequestFor("sessions/x")).status()),
            v1::ERROR_REASON_SESSION_NOT_FOUND);
  EXPECT_EQ(ReasonOf(GetSession(context_, RequestFor("x")).status()), v1::ERROR_REASON_NAME_INVALID);
}

}  // namespace
}  // namespace semmap::server
