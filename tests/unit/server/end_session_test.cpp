#include "handler_fixture.h"
#include "server/handlers/session_handlers.h"
#include "slam/common/notification.h"

namespace semmap::server {
namespace {

using EndSessionTest = HandlerTest;

absl::StatusOr<v1::Session> EndAndWait(const ServiceContext& context, const std::string& name) {
  v1::EndSessionRequest request;
  request.set_name(name);
  absl::StatusOr<v1::Session> result = absl::InternalError("not called");
  Notification done;
  EndSession(context, request, [&](absl::StatusOr<v1::Session> session) {
    result = std::move(session);
    done.Notify();
  });
  EXPECT_TRUE(done.WaitForNotificationWithTimeout(absl::Seconds(10)));
  return result;
}

TEST_F(EndSessionTest, StoresAndTellsWhy) {
  const auto running = OpenSession("town");
  ASSERT_NE(running, nullptr);
  const std::string name = "sessions/" + running->identity().id;
  const auto session = EndAndWait(context_, name);
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->state(), v1::SESSION_STATE_FINISHED);
  EXPECT_EQ(session->end_reason(), v1::SESSION_END_REASON_OPERATOR);
  EXPECT_EQ(sessions_->size(), 0U);
  EXPECT_TRUE(store_->GetSession(running->identity().id)->ended_at.has_value());
  // Again: as it is.
  EXPECT_EQ(EndAndWait(context_, name)->end_reason(), v1::SESSION_END_REASON_OPERATOR);
}

TEST_F(EndSessionTest, NoSuchSession) {
  EXPECT_EQ(ReasonOf(EndAndWait(context_, "sessions/x").status()), v1::ERROR_REASON_SESSION_NOT_FOUND);
  EXPECT_EQ(ReasonOf(EndAndWait(context_, "x").status()), v1::ERROR_REASON_NAME_INVALID);
}

}  // namespace
}  // namespace semmap::server
