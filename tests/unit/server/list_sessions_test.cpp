#include "handler_fixture.h"
#include "server/handlers/session_handlers.h"

namespace semmap::server {
namespace {

class ListSessionsTest : public HandlerTest {
 protected:
  std::vector<std::string> Names() {
    std::vector<std::string> names;
    request_.clear_page_token();
    do {
      const auto response = ListSessions(context_, request_);
      EXPECT_TRUE(response.ok()) << response.status();
      if (!response.ok()) return names;
      for (const v1::Session& session : response->sessions()) names.push_back(session.name());
      request_.set_page_token(response->next_page_token());
    } while (!request_.page_token().empty());
    return names;
  }

  v1::ListSessionsRequest request_;
};

TEST_F(ListSessionsTest, GivesEverySessionOnceInPages) {
  MakeMap("a", "s1", 1);
  MakeMap("b", "s2", 1);
  for (const char* name : {"s3", "s4"}) {
    ASSERT_TRUE(store_->StartSession({store_->GetMap("a")->id, name, "truck", 1, SmallRig()}).ok());
  }
  const std::vector<std::string> all = {"sessions/s1", "sessions/s3", "sessions/s4", "sessions/s2"};
  EXPECT_EQ(Names(), all);
  for (const int page : {1, 2, 3, 4}) {
    request_.set_page_size(page);
    EXPECT_EQ(Names(), all) << page;
  }
}

TEST_F(ListSessionsTest, Filters) {
  MakeMap("a", "s1", 1);
  MakeMap("b", "s2", 1);
  const auto running = OpenSession("c");
  ASSERT_NE(running, nullptr);
  request_.set_state(v1::SESSION_STATE_INTERRUPTED);
  EXPECT_EQ(Names(), (std::vector<std::string>{"sessions/" + running->identity().id}));
  request_.clear_state();
  request_.set_map("maps/b");
  EXPECT_EQ(Names(), (std::vector<std::string>{"sessions/s2"}));
  request_.set_vehicle_id("truck");
  EXPECT_TRUE(Names().empty());
  request_.set_map("maps/nowhere");
  EXPECT_EQ(ReasonOf(ListSessions(context_, request_).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
}

}  // namespace
}  // namespace semmap::server
