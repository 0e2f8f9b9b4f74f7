#include "slam/evaluation/trajectory_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slam/evaluation/line_reader.h"
#include "tests/unit/evaluation/evaluation_test_util.h"

namespace semmap {
namespace {

using ::testing::HasSubstr;

TEST(ParseSeconds, IsExactToTheNanosecond) {
  EXPECT_EQ(ParseSeconds("1311868164.363181"), 1311868164363181000);
  EXPECT_EQ(ParseSeconds("1403636579.763555527"), 1403636579763555527);
  EXPECT_EQ(ParseSeconds("0"), 0);
  EXPECT_EQ(ParseSeconds("-1.5"), -1500000000);
  EXPECT_EQ(ParseSeconds("1.037359e-01"), 103735900);
}

TEST(ParseSeconds, RefusesWhatIsNoTime) {
  for (const char* text : {"", "-", "abc", "nan", "inf", "1e300", "99999999999999999999", "1.2.3", "12x"}) {
    EXPECT_FALSE(ParseSeconds(text).has_value()) << text;
  }
}

TEST(FormatSeconds, ReadsBackTheSame) {
  for (const TimestampNs time :
       {int64_t{0}, int64_t{1}, int64_t{-1}, int64_t{1403636579763555527}, int64_t{-2500000000}}) {
    EXPECT_EQ(ParseSeconds(FormatSeconds(time)), time);
  }
}

class TrajectoryRoundTrip : public ::testing::TestWithParam<TrajectoryFormat> {};

TEST_P(TrajectoryRoundTrip, WritesWhatItReads) {
  const Trajectory trajectory = BendTrajectory(40);
  const std::string path = WriteTemp("round_trip.txt", "");
  ASSERT_TRUE(WriteTrajectory(path, trajectory, GetParam()).ok());
  const auto read = ReadTrajectory(path, GetParam());
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), trajectory.size());
  EXPECT_EQ(read->timed, GetParam() == TrajectoryFormat::kTum);
  for (size_t i = 0; i < trajectory.size(); ++i) {
    const SE3 difference = read->poses[i].map_from_camera.Inverse() * trajectory.poses[i].map_from_camera;
    EXPECT_LT(difference.Log().norm(), 1e-12);
    EXPECT_EQ(read->poses[i].timestamp, read->timed ? trajectory.poses[i].timestamp : 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, TrajectoryRoundTrip,
                         ::testing::Values(TrajectoryFormat::kTum, TrajectoryFormat::kKitti));

TEST(WriteTrajectory, OppositeQuaternionsGiveTheSameText) {
  const Eigen::Quaterniond q(0.5, -0.5, 0.5, 0.5);
  const Trajectory one{{{0, SE3(q, {1, 2, 3})}}};
  const Trajectory two{{{0, SE3(Eigen::Quaterniond(-q.coeffs()), {1, 2, 3})}}};
  EXPECT_EQ(FormatTrajectory(one, TrajectoryFormat::kTum), FormatTrajectory(two, TrajectoryFormat::kTum));
}

TEST(WriteTrajectory, SaysWhenItCannotWrite) {
  const absl::Status status =
      WriteTrajectory("/no/such/folder/x.txt", BendTrajectory(3), TrajectoryFormat::kTum);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
}

TEST(ReadTum, SkipsCommentsAndTakesCommasAndCarriageReturns) {
  const std::string path = WriteTemp("ok.txt", "# time tx ty tz\n\n1.5 1 2 3 0 0 0 1\r\n1.6,1,2,4,0,0,0,1");
  const auto read = ReadTumTrajectory(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ(read->poses[1].timestamp, 1600000000);
  EXPECT_DOUBLE_EQ(read->poses[1].map_from_camera.translation().z(), 4.0);
}

struct BadFile {
  const char* text;
  const char* complaint;
};

void ExpectComplaint(const absl::StatusOr<Trajectory>& read, const BadFile& bad) {
  ASSERT_FALSE(read.ok()) << bad.text;
  EXPECT_EQ(read.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(read.status().message()), HasSubstr(bad.complaint)) << bad.text;
}

TEST(ReadTum, NamesTheLineOfWhatIsWrong) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  for (const BadFile& bad : {
           BadFile{"2 0 0 0 0 0 0\n", ":2: expected 8 fields"},
           BadFile{"2 0 0 x 0 0 0 1\n", ":2: field 4 is not a finite number"},
           BadFile{"2 0 0 nan 0 0 0 1\n", ":2: field 4 is not a finite number"},
           BadFile{"2 0 0 0 0 0 0 0\n", ":2: the quaternion is not of unit length"},
           BadFile{"# comment\n\n0.9 0 0 0 0 0 0 1\n", ":4: the time is earlier"},
           BadFile{"later 0 0 0 0 0 0 1\n", ":2: the first field is not a time"},
       }) {
    ExpectComplaint(ReadTumTrajectory(WriteTemp("bad.txt", good + bad.text)), bad);
  }
}

TEST(ReadKitti, NamesTheLineOfWhatIsWrong) {
  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  for (const BadFile& bad : {
           BadFile{"1 0 0 0\n", ":2: expected the 12 numbers"},
           BadFile{"1 0 0 0 0 1 0 inf 0 0 1 0\n", ":2: field 8 is not a finite number"},
           BadFile{"2 0 0 0 0 1 0 0 0 0 1 0\n", ":2: the left 3x3 block is not a rotation"},
           BadFile{"-1 0 0 0 0 1 0 0 0 0 1 0\n", ":2: the left 3x3 block is not a rotation"},
       }) {
    ExpectComplaint(ReadKittiTrajectory(WriteTemp("bad.txt", good + bad.text)), bad);
  }
}

TEST(ReadTrajectory, RefusesEmptyMissingAndEndlessFiles) {
  EXPECT_EQ(ReadTumTrajectory(WriteTemp("empty.txt", "# nothing\n")).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadTumTrajectory("/no/such/file").status().code(), absl::StatusCode::kNotFound);
  const auto endless = ReadTumTrajectory(WriteTemp("line.txt", std::string(100'000, '1')));
  EXPECT_THAT(std::string(endless.status().message()), HasSubstr(":1: line is longer than"));
}

TEST(ReadTimes, TakesScientificNotationAndMustGrow) {
  const auto times = ReadTimes(WriteTemp("times.txt", "0.000000e+00\n1.037359e-01\n"));
  ASSERT_TRUE(times.ok()) << times.status();
  EXPECT_EQ((*times)[1], 103735900);
  EXPECT_FALSE(ReadTimes(WriteTemp("times.txt", "1\n1\n")).ok());
  EXPECT_FALSE(ReadTimes(WriteTemp("times.txt", "1 2\n")).ok());
}

TEST(AttachTimes, NeedsATimeForEachPose) {
  Trajectory trajectory = BendTrajectory(3);
  trajectory.timed = false;
  EXPECT_FALSE(AttachTimes({1, 2}, &trajectory).ok());
  EXPECT_FALSE(trajectory.timed);
  ASSERT_TRUE(AttachTimes({1, 2, 3, 4}, &trajectory).ok());
  EXPECT_TRUE(trajectory.timed);
  EXPECT_EQ(trajectory.poses[2].timestamp, 3);
}

}  // namespace
}  // namespace semmap
