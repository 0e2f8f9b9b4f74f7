#include "raw_stream.h"
#include "service_fixture.h"

namespace semmap {
namespace {

using FlowControlTest = ServiceTest;

TEST_F(FlowControlTest, AVehicleWaitsForCredit) {
  gate_.Close();
  Recorder recorder;
  client::DriveOptions options = DriveTo("town");
  options.send_timeout = std::chrono::milliseconds(200);
  auto drive = client::Drive::Start(Connect(), options, recorder.Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
    EXPECT_TRUE((*drive)->HasCredit());
    ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  }
  EXPECT_FALSE((*drive)->HasCredit());
  EXPECT_EQ((*drive)->Send(Frame(5)).code(), absl::StatusCode::kDeadlineExceeded);
  gate_.Open();
  // Frame 5 was kept and goes with the end.
  EXPECT_TRUE((*drive)->Finish().ok());
  EXPECT_EQ(recorder.answered(), UpTo(5));
}

TEST_F(FlowControlTest, FramesWithoutCreditAreRefusedThoseBeforeAreStored) {
  gate_.Close();
  RawStream stream(Connect()->channel());
  ASSERT_TRUE(stream.WriteHello(Rig(), "town"));
  v1::StreamFramesResponse response;
  ASSERT_TRUE(stream.Read(&response));
  ASSERT_EQ(response.started().credit(), 4);
  for (uint64_t sequence = 1; sequence <= 5; ++sequence) stream.WriteFrame(Frame(sequence));
  // The fifth is there when the session has begun to end.
  client::Client client(Connect());
  const absl::Time deadline = absl::Now() + absl::Seconds(10);
  while (client.GetSession(response.started().session())->state() != v1::SESSION_STATE_FINISHING &&
         absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(5));
  }
  gate_.Open();
  const absl::Status status = stream.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(client::ErrorReason(status), "CREDIT_EXCEEDED");
  EXPECT_EQ(client::ErrorMetadata(status, "sequence"), "5");
  EXPECT_EQ(StoredFrames("town"), UpTo(4));
}

TEST_F(FlowControlTest, LatestWinsDropsWhatWaitsAndCounts) {
  gate_.Close();
  Recorder recorder;
  client::DriveOptions options = DriveTo("town");
  options.overload_policy = v1::OVERLOAD_POLICY_LATEST_WINS;
  auto drive = client::Drive::Start(Connect(), options, recorder.Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_TRUE((*drive)->Send(Frame(1)).ok());
  ASSERT_TRUE(gate_.WaitForFrames(1));
  // The first is in the tracker; of the others, many more than the window, only the last survives.
  for (uint64_t sequence = 2; sequence <= 30; ++sequence) {
    ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  }
  client::Client client(Connect());
  const absl::Time deadline = absl::Now() + absl::Seconds(10);
  while (client.GetSession((*drive)->started().session())->last_received_sequence() < 30 &&
         absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(5));
  }
  gate_.Open();
  const auto summary = (*drive)->Finish();
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(recorder.answered(), (std::vector<uint64_t>{1, 30}));
  EXPECT_EQ(recorder.dropped().size(), 28U);
  EXPECT_EQ(recorder.dropped().front(), 2U);
  EXPECT_EQ(recorder.dropped().back(), 29U);
  EXPECT_EQ(summary->session().statistics().frames_dropped(), 28U);
  EXPECT_EQ(summary->session().statistics().frames_received(), 30U);
  EXPECT_EQ(summary->session().statistics().frames_processed(), 2U);
}

}  // namespace
}  // namespace semmap
