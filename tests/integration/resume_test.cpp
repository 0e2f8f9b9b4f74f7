#include "raw_stream.h"
#include "service_fixture.h"

namespace semmap {
namespace {

class ResumeTest : public ServiceTest {
 protected:
  // Sending is no proof of arrival.
  void WaitUntilReceived(const std::string& session, uint64_t sequence) {
    client::Client client(Connect());
    const absl::Time deadline = absl::Now() + absl::Seconds(20);
    while (client.GetSession(session)->last_received_sequence() < sequence) {
      ASSERT_LT(absl::Now(), deadline);
      absl::SleepFor(absl::Milliseconds(5));
    }
  }

  // Until the session is in `state`; its last description.
  v1::Session WaitForState(const std::string& session, v1::SessionState state) {
    client::Client client(Connect());
    const absl::Time deadline = absl::Now() + absl::Seconds(20);
    while (absl::Now() < deadline) {
      const auto now = client.GetSession(session);
      if (now.ok() && now->state() == state) return *now;
      absl::SleepFor(absl::Milliseconds(5));
    }
    ADD_FAILURE() << "the session did not reach " << v1::SessionState_Name(state);
    return {};
  }
};

TEST_F(ResumeTest, AStreamThatIsCutAgainAndAgainLosesNothing) {
  Recorder recorder;
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), recorder.Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (uint64_t sequence = 1; sequence <= 60; ++sequence) {
    if (sequence % 7 == 0) (*drive)->CutStream();
    ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok()) << sequence;
  }
  const auto summary = (*drive)->Finish();
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(recorder.answered(), UpTo(60));
  EXPECT_EQ(gate_.seen(), UpTo(60));
  EXPECT_EQ(StoredFrames("town"), UpTo(60));
  EXPECT_GE(recorder.resumes(), 8);
  EXPECT_EQ(summary->session().statistics().resumes(), static_cast<uint64_t>(recorder.resumes()));
}

TEST_F(ResumeTest, FramesInTheQueueAreWorkedOffMeanwhile) {
  gate_.Close();
  Recorder recorder;
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), recorder.Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  const std::string session = (*drive)->started().session();
  WaitUntilReceived(session, 4);
  (*drive)->CutStream();
  WaitForState(session, v1::SESSION_STATE_INTERRUPTED);
  gate_.Open();
  ASSERT_TRUE(gate_.WaitForFrames(4));
  ASSERT_TRUE((*drive)->WaitForAnswers(std::chrono::seconds(10)).ok());
  EXPECT_EQ(recorder.answered(), UpTo(4));
  EXPECT_TRUE((*drive)->Finish().ok());
}

TEST_F(ResumeTest, AVehicleThatVanishesIsStoredAfterTheTimeout) {
  server_.reset();
  config_.server.resume_timeout_s = 0.2;
  StartServer();
  std::string session;
  std::string token;
  {
    auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
    ASSERT_TRUE(drive.ok()) << drive.status();
    session = (*drive)->started().session();
    token = (*drive)->started().resume_token();
    for (uint64_t sequence = 1; sequence <= 8; ++sequence) ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
    ASSERT_TRUE((*drive)->WaitForAnswers(std::chrono::seconds(10)).ok());
  }
  const v1::Session over = WaitForState(session, v1::SESSION_STATE_FINISHED);
  EXPECT_EQ(over.end_reason(), v1::SESSION_END_REASON_RESUME_TIMEOUT);
  EXPECT_EQ(StoredFrames("town"), UpTo(8));

  RawStream late(Connect()->channel());
  v1::StreamFramesRequest resume;
  resume.mutable_resume()->set_session(session);
  resume.mutable_resume()->set_resume_token(token);
  late.Write(resume);
  const absl::Status status = late.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(client::ErrorReason(status), "SESSION_NOT_RESUMABLE");
}

TEST_F(ResumeTest, WithoutTheTokenNobodyTakesASessionOver) {
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  RawStream thief(Connect()->channel());
  v1::StreamFramesRequest resume;
  resume.mutable_resume()->set_session((*drive)->started().session());
  resume.mutable_resume()->set_resume_token("0123456789abcdef0123456789abcdef");
  thief.Write(resume);
  EXPECT_EQ(client::ErrorReason(thief.Finish()), "SESSION_NOT_RESUMABLE");
  ASSERT_TRUE((*drive)->Send(Frame(1)).ok());
  EXPECT_TRUE((*drive)->Finish().ok());
}

// A vehicle that comes back before the server noticed that its old link is dead.
TEST_F(ResumeTest, TheNewStreamReplacesTheOldOne) {
  RawStream old_stream(Connect()->channel());
  ASSERT_TRUE(old_stream.WriteHello(Rig(), "town"));
  v1::StreamFramesResponse response;
  ASSERT_TRUE(old_stream.Read(&response));
  const v1::SessionStarted started = response.started();
  old_stream.WriteFrame(Frame(1));
  do {
    ASSERT_TRUE(old_stream.Read(&response));
  } while (!response.has_estimate());
  ASSERT_EQ(response.estimate().sequence(), 1U);

  RawStream new_stream(Connect()->channel());
  v1::StreamFramesRequest resume;
  resume.mutable_resume()->set_session(started.session());
  resume.mutable_resume()->set_resume_token(started.resume_token());
  ASSERT_TRUE(new_stream.Write(resume));
  ASSERT_TRUE(new_stream.Read(&response));
  EXPECT_EQ(response.started().last_received_sequence(), 1U);
  EXPECT_EQ(response.started().credit(), 4);
  // The answer that the vehicle says it did not get comes again.
  ASSERT_TRUE(new_stream.Read(&response));
  EXPECT_EQ(response.estimate().sequence(), 1U);
  EXPECT_EQ(client::ErrorReason(old_stream.Finish()), "SESSION_RESUMED_ELSEWHERE");

  // A frame that is sent again is passed over.
  new_stream.WriteFrame(Frame(1));
  new_stream.WriteFrame(Frame(2));
  v1::StreamFramesRequest end;
  end.mutable_end();
  new_stream.Write(end);
  v1::SessionSummary summary;
  while (new_stream.Read(&response)) {
    if (response.has_summary()) summary = response.summary();
  }
  EXPECT_TRUE(new_stream.Finish().ok());
  EXPECT_EQ(summary.session().statistics().frames_processed(), 2U);
}

TEST_F(ResumeTest, ALostSummaryIsFoundAgain) {
  gate_.Close();
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_TRUE((*drive)->Send(Frame(1)).ok());
  ASSERT_TRUE(gate_.WaitForFrames(1));
  std::thread link([&] {
    absl::SleepFor(absl::Milliseconds(100));
    (*drive)->CutStream();
    gate_.Open();
  });
  const auto summary = (*drive)->Finish();
  link.join();
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->session().end_reason(), v1::SESSION_END_REASON_CLIENT);
  EXPECT_EQ(summary->session().statistics().frames_processed(), 1U);
}

}  // namespace
}  // namespace semmap
