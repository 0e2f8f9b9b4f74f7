#include <thread>

#include "service_fixture.h"

namespace semmap {
namespace {

using DriveTest = ServiceTest;

TEST_F(DriveTest, EveryFrameIsAnsweredInOrderAndStored) {
  Recorder recorder;
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), recorder.Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ((*drive)->started().map(), "maps/town");
  EXPECT_EQ((*drive)->started().credit(), 4);
  for (uint64_t sequence = 1; sequence <= 33; ++sequence) {
    ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  }
  const auto summary = (*drive)->Finish();
  ASSERT_TRUE(summary.ok()) << summary.status();

  EXPECT_EQ(recorder.answered(), UpTo(33));
  const v1::FrameEstimate last = recorder.estimates().back();
  EXPECT_EQ(last.state(), v1::TRACKING_STATE_TRACKING);
  EXPECT_EQ(last.timestamp_ns(), 3300);
  EXPECT_EQ(last.map_from_camera().translation().x(), 33);
  EXPECT_EQ(last.covariance().upper_triangle_size(), 21);
  EXPECT_EQ(last.covariance().upper_triangle(0), 1e-4);
  EXPECT_EQ(last.inliers(), 100);
  EXPECT_EQ(last.map_version(), 7U);

  const v1::Session& session = summary->session();
  EXPECT_EQ(session.state(), v1::SESSION_STATE_FINISHED);
  EXPECT_EQ(session.end_reason(), v1::SESSION_END_REASON_CLIENT);
  EXPECT_EQ(session.statistics().frames_received(), 33U);
  EXPECT_EQ(session.statistics().frames_processed(), 33U);
  EXPECT_EQ(session.statistics().frames_tracked(), 33U);
  EXPECT_EQ(session.statistics().keyframes(), 7);
  EXPECT_EQ(session.last_acknowledged_sequence(), 33U);

  const std::vector<uint64_t> acknowledged = recorder.acknowledged();
  ASSERT_FALSE(acknowledged.empty());
  EXPECT_EQ(acknowledged.back(), 33U);
  EXPECT_TRUE(std::is_sorted(acknowledged.begin(), acknowledged.end()));
  EXPECT_EQ(StoredFrames("town"), UpTo(33));
}

// What was acknowledged is in the store at that moment, not only at the end.
TEST_F(DriveTest, AnAcknowledgementMeansThatItIsStored) {
  Recorder recorder;
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), recorder.Observer());
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (uint64_t sequence = 1; sequence <= 12; ++sequence) {
    ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  }
  ASSERT_TRUE((*drive)->WaitForAnswers(std::chrono::seconds(10)).ok());
  const absl::Time deadline = absl::Now() + absl::Seconds(10);
  while ((recorder.acknowledged().empty() || recorder.acknowledged().back() < 11) && absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(5));
  }
  ASSERT_FALSE(recorder.acknowledged().empty());
  EXPECT_EQ(recorder.acknowledged().back(), 11U);
  EXPECT_EQ(StoredFrames("town"), UpTo(11));
  EXPECT_TRUE((*drive)->Finish().ok());
}

TEST_F(DriveTest, ADriveWithoutFramesIsADrive) {
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  const auto summary = (*drive)->Finish();
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->session().statistics().frames_received(), 0U);
}

TEST_F(DriveTest, FourVehiclesAtOnceDoNotDisturbEachOther) {
  std::vector<Recorder> recorders(4);
  std::vector<std::thread> vehicles;
  for (size_t i = 0; i < 4; ++i) {
    vehicles.emplace_back([&, i] {
      auto drive =
          client::Drive::Start(Connect(), DriveTo("map" + std::to_string(i)), recorders[i].Observer());
      ASSERT_TRUE(drive.ok()) << drive.status();
      for (uint64_t sequence = 1; sequence <= 40 + i; ++sequence) {
        ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
      }
      const auto summary = (*drive)->Finish();
      ASSERT_TRUE(summary.ok()) << summary.status();
    });
  }
  for (std::thread& vehicle : vehicles) vehicle.join();
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(recorders[i].answered(), UpTo(40 + i));
    EXPECT_EQ(StoredFrames("map" + std::to_string(i)), UpTo(40 + i));
  }
}

TEST_F(DriveTest, AHelloThatIsRefusedSaysWhy) {
  client::DriveOptions options = DriveTo("town");
  options.mode = v1::SESSION_MODE_EXTEND;
  auto drive = client::Drive::Start(Connect(), options, {});
  EXPECT_EQ(drive.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(client::ErrorReason(drive.status()), "MAP_NOT_FOUND");
  options.mode = v1::SESSION_MODE_MAP;
  options.rig.mutable_camera()->set_fx(std::numeric_limits<double>::quiet_NaN());
  drive = client::Drive::Start(Connect(), options, {});
  EXPECT_EQ(drive.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(client::ErrorReason(drive.status()), "RIG_INVALID");
}

TEST_F(DriveTest, AMapThatHoldsKeyFramesIsNotMadeAgain) {
  auto first = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(first.ok()) << first.status();
  auto meanwhile = client::Drive::Start(Connect(), DriveTo("town"), {});
  EXPECT_EQ(client::ErrorReason(meanwhile.status()), "MAP_IN_USE");
  ASSERT_TRUE((*first)->Send(Frame(1)).ok());
  ASSERT_TRUE((*first)->Finish().ok());
  auto second = client::Drive::Start(Connect(), DriveTo("town"), {});
  EXPECT_EQ(second.status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(client::ErrorReason(second.status()), "MAP_NOT_EMPTY");
}

// What the store refuses ends the session with the store's reason, and the server goes on.
TEST_F(DriveTest, AStoreThatFailsEndsTheSession) {
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  {
    const auto behind_its_back = server::OpenStoreIn(directory_);
    ASSERT_NE(behind_its_back, nullptr);
    ASSERT_TRUE(behind_its_back->DeleteMap(behind_its_back->GetMap("town")->id).ok());
  }
  absl::Status status;
  for (uint64_t sequence = 1; status.ok() && sequence < 1000; ++sequence)
    status = (*drive)->Send(Frame(sequence));
  EXPECT_EQ(client::ErrorReason(status), "MAP_NOT_FOUND") << status;
  auto next = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(next.ok()) << next.status();
  ASSERT_TRUE((*next)->Send(Frame(1)).ok());
  EXPECT_TRUE((*next)->Finish().ok());
}

TEST_F(DriveTest, EndSessionEndsTheStream) {
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_TRUE((*drive)->Send(Frame(1)).ok());
  ASSERT_TRUE(gate_.WaitForFrames(1)) << "it must have arrived to be stored";
  const auto ended = client::Client(Connect()).EndSession((*drive)->started().session());
  ASSERT_TRUE(ended.ok()) << ended.status();
  EXPECT_EQ(ended->end_reason(), v1::SESSION_END_REASON_OPERATOR);
  const auto summary = (*drive)->Finish();
  EXPECT_EQ(client::ErrorReason(summary.status()), "SESSION_ENDED_BY_OPERATOR");
  EXPECT_EQ(StoredFrames("town"), UpTo(1));
}

}  // namespace
}  // namespace semmap
