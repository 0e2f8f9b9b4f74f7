#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

class GetTrajectoryTest : public HandlerTest {
 protected:
  GetTrajectoryTest() {
    MakeMap("town", "s1", 12);
    request_.set_map("maps/town");
  }

  // All messages.
  std::vector<v1::GetTrajectoryResponse> Read() {
    std::vector<v1::GetTrajectoryResponse> messages;
    auto source = GetTrajectory(context_, request_);
    EXPECT_TRUE(source.ok()) << source.status();
    if (!source.ok()) return messages;
    v1::GetTrajectoryResponse response;
    while (*(*source)->Next(&response)) {
      messages.push_back(response);
      response.Clear();
    }
    return messages;
  }

  v1::GetTrajectoryRequest request_;
};

TEST_F(GetTrajectoryTest, SendsEveryFrameInPieces) {
  context_.config.query_chunk = 5;
  const auto messages = Read();
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(messages[0].session(), "sessions/s1");
  uint64_t expected = 1;
  for (const auto& message : messages) {
    for (int i = 0; i < message.trajectory().sequences_size(); ++i, ++expected) {
      EXPECT_EQ(message.trajectory().sequences(i), expected);
      EXPECT_EQ(message.trajectory().timestamps_ns(i), static_cast<int64_t>(expected) * 100);
      EXPECT_NEAR(message.trajectory().poses(7 * i), static_cast<double>(expected), 1e-9);
      EXPECT_EQ(message.trajectory().poses(7 * i + 6), 1);
    }
  }
  EXPECT_EQ(expected, 13U);
}

TEST_F(GetTrajectoryTest, FiltersByTimeAndSession) {
  request_.mutable_time()->set_start_ns(300);
  request_.mutable_time()->set_end_ns(500);
  request_.set_session("sessions/s1");
  const auto messages = Read();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].trajectory().sequences_size(), 2);
  request_.mutable_time()->set_end_ns(100);
  EXPECT_EQ(ReasonOf(GetTrajectory(context_, request_).status()), v1::ERROR_REASON_FIELD_INVALID);
}

}  // namespace
}  // namespace semmap::server
