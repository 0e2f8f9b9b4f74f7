#include "server/session_registry.h"

#include <limits>

#include "absl/time/clock.h"
#include "handler_fixture.h"
#include "slam/common/notification.h"

namespace semmap::server {
namespace {

// A stream that is asked and never told.
class SilentOutput : public StreamOutput {
 public:
  void Wake() override {}
};

class SessionRegistryTest : public HandlerTest {
 protected:
  SessionRegistryTest() {
    hello_.set_vehicle_id("car");
    hello_.set_map("maps/town");
    hello_.set_mode(v1::SESSION_MODE_MAP);
    hello_.mutable_rig()->set_sensor(v1::SENSOR_TYPE_MONO);
    v1::CameraIntrinsics* camera = hello_.mutable_rig()->mutable_camera();
    camera->set_width(64);
    camera->set_height(48);
    camera->set_fx(50);
    camera->set_fy(50);
    camera->set_cx(32);
    camera->set_cy(24);
    camera->set_distortion_model(v1::DISTORTION_MODEL_NONE);
  }
  v1::ErrorReason Refusal() { return ReasonOf(sessions_->Open(hello_).status()); }

  v1::SessionHello hello_;
};

TEST_F(SessionRegistryTest, RefusesABadHelloAndLeavesNothing) {
  hello_.set_vehicle_id("a car");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_NAME_INVALID);
  hello_.set_vehicle_id("car");
  hello_.set_map("town");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_NAME_INVALID);
  hello_.set_map("maps/town");
  hello_.clear_mode();
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  hello_.set_mode(v1::SESSION_MODE_LOCALIZE);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_NOT_FOUND);
  ASSERT_TRUE(store_->CreateMap({"empty", 1, SmallRig(), false}).ok());
  hello_.set_map("maps/empty");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_EMPTY);
  hello_.set_map("maps/town");
  hello_.set_mode(v1::SESSION_MODE_MAP);
  hello_.mutable_rig()->mutable_camera()->set_fx(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_RIG_INVALID);
  EXPECT_EQ(sessions_->size(), 0U);
  EXPECT_FALSE(store_->GetMap("town").ok());
  EXPECT_FALSE(sessions_->IsMapInUse("town"));
}

TEST_F(SessionRegistryTest, AMapIsMadeOnceByOneSession) {
  ASSERT_TRUE(sessions_->Open(hello_).ok());
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_IN_USE);
  MakeMap("full", "s1", 6);
  hello_.set_map("maps/full");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_NOT_EMPTY);
}

TEST_F(SessionRegistryTest, ManyReadAMapAndManyExtendIt) {
  MakeMap("full", "s1", 6);
  hello_.set_map("maps/full");
  hello_.set_mode(v1::SESSION_MODE_LOCALIZE);
  ASSERT_TRUE(sessions_->Open(hello_).ok());
  ASSERT_TRUE(sessions_->Open(hello_).ok());
  hello_.set_mode(v1::SESSION_MODE_EXTEND);
  const auto extender = sessions_->Open(hello_);
  ASSERT_TRUE(extender.ok()) << extender.status();
  ASSERT_TRUE(sessions_->Open(hello_).ok());
  hello_.set_mode(v1::SESSION_MODE_MAP);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_IN_USE);
  hello_.set_mode(v1::SESSION_MODE_LOCALIZE);
  EXPECT_TRUE(sessions_->Open(hello_).ok());
  EXPECT_EQ(sessions_->size(), 5U);
  EXPECT_TRUE(sessions_->IsMapInUse("full"));
}

TEST_F(SessionRegistryTest, AMapIsExtendedWithTheCamerasThatMadeIt) {
  MakeMap("full", "s1", 6);
  hello_.set_map("maps/full");
  hello_.set_mode(v1::SESSION_MODE_EXTEND);
  hello_.mutable_rig()->mutable_camera()->set_fx(51);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_RIG_INVALID);
  hello_.set_mode(v1::SESSION_MODE_LOCALIZE);
  EXPECT_TRUE(sessions_->Open(hello_).ok()) << "to look, any camera will do";
}

TEST_F(SessionRegistryTest, ARepeatedHelloFindsItsSession) {
  hello_.set_request_id("r1");
  const auto first = sessions_->Open(hello_);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_FALSE(first->resumed);
  const auto second = sessions_->Open(hello_);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_TRUE(second->resumed);
  EXPECT_EQ(first->session, second->session);
}

TEST_F(SessionRegistryTest, ResumeWantsTheToken) {
  const auto opened = sessions_->Open(hello_);
  ASSERT_TRUE(opened.ok());
  v1::SessionResume resume;
  resume.set_session("sessions/" + opened->session->identity().id);
  EXPECT_EQ(ReasonOf(sessions_->Resume(resume).status()), v1::ERROR_REASON_SESSION_NOT_RESUMABLE);
  resume.set_resume_token(std::string(32, '0'));
  EXPECT_EQ(ReasonOf(sessions_->Resume(resume).status()), v1::ERROR_REASON_SESSION_NOT_RESUMABLE);
  resume.set_resume_token(opened->session->identity().resume_token);
  EXPECT_TRUE(sessions_->Resume(resume).ok());
}

TEST_F(SessionRegistryTest, WhoHearsOfTheEndFindsTheMapFree) {
  const auto opened = sessions_->Open(hello_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  VehicleSession& session = *opened->session;
  const auto output = std::make_shared<SilentOutput>();
  ASSERT_TRUE(session.Attach(output, false, 0).has_value());
  const auto summary_is_there = [&] {
    v1::StreamFramesResponse response;
    absl::Status status;
    while (session.NextResponse(output.get(), &response, &status) == VehicleSession::Next::kMessage) {
      if (response.has_summary()) return true;
    }
    return false;
  };
  bool was_in_use = true;
  bool was_summed_up = true;
  Notification told;
  session.WhenOver([&](const v1::Session&) {
    was_in_use = sessions_->IsMapInUse("town");
    was_summed_up = summary_is_there();
    told.Notify();
  });
  session.End(v1::SESSION_END_REASON_CLIENT, absl::OkStatus());
  ASSERT_TRUE(told.WaitForNotificationWithTimeout(absl::Seconds(10)));
  EXPECT_FALSE(was_in_use);
  EXPECT_FALSE(was_summed_up) << "the vehicle hears of it last";
  const absl::Time deadline = absl::Now() + absl::Seconds(10);
  while (!summary_is_there() && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(1));
  EXPECT_LT(absl::Now(), deadline);
}

TEST_F(SessionRegistryTest, OnlySoManySessions) {
  environment_.config.max_sessions = 2;
  SessionRegistry small(environment_, SlamConfig(), FakeSession::Factory(nullptr), &timer_);
  for (const char* map : {"maps/a", "maps/b"}) {
    hello_.set_map(map);
    ASSERT_TRUE(small.Open(hello_).ok());
  }
  hello_.set_map("maps/c");
  EXPECT_EQ(ReasonOf(small.Open(hello_).status()), v1::ERROR_REASON_TOO_MANY_SESSIONS);
  small.Drain(absl::Seconds(10));
  EXPECT_EQ(small.size(), 0U);
  EXPECT_EQ(ReasonOf(small.Open(hello_).status()), v1::ERROR_REASON_SHUTTING_DOWN);
}

}  // namespace
}  // namespace semmap::server
