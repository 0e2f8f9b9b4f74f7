#include "slam/evaluation/trajectory_io.h"

#include <array>
#include <cmath>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/line_reader.h"

namespace semmap {
namespace {

// Published files round to six or seven digits; anything further off is not a rotation but a wrong column.
constexpr double kRotationTolerance = 1e-2;

template <size_t count>
absl::Status ReadNumbers(const LineReader& reader, size_t first, std::array<double, count>* numbers) {
  for (size_t i = 0; i < count; ++i) {
    const std::optional<double> number = reader.Number(first + i);
    if (!number) return reader.Error(absl::StrCat("field ", first + i + 1, " is not a finite number"));
    (*numbers)[i] = *number;
  }
  return absl::OkStatus();
}

absl::StatusOr<StampedPose> ParseTumLine(const LineReader& reader) {
  if (reader.fields().size() != 8) {
    return reader.Error(
        absl::StrCat("expected 8 fields (time tx ty tz qx qy qz qw), found ", reader.fields().size()));
  }
  const std::optional<TimestampNs> timestamp = reader.Seconds(0);
  if (!timestamp) return reader.Error("the first field is not a time in seconds");
  std::array<double, 7> n{};
  SEMMAP_RETURN_IF_ERROR(ReadNumbers(reader, 1, &n));
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (std::abs(rotation.norm() - 1.0) > kRotationTolerance) {
    return reader.Error("the quaternion is not of unit length");
  }
  return StampedPose{*timestamp, SE3(rotation, Eigen::Vector3d(n[0], n[1], n[2]))};
}

absl::StatusOr<StampedPose> ParseKittiLine(const LineReader& reader) {
  if (reader.fields().size() != 12) {
    return reader.Error(
        absl::StrCat("expected the 12 numbers of a 3x4 matrix, found ", reader.fields().size(), " fields"));
  }
  std::array<double, 12> n{};
  SEMMAP_RETURN_IF_ERROR(ReadNumbers(reader, 0, &n));
  Eigen::Matrix3d rotation;
  rotation << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error < kRotationTolerance) || rotation.determinant() < 0) {
    return reader.Error("the left 3x3 block is not a rotation");
  }
  return StampedPose{0, SE3(rotation, Eigen::Vector3d(n[3], n[7], n[11]))};
}

using ParseLine = absl::StatusOr<StampedPose> (*)(const LineReader& reader);

absl::StatusOr<Trajectory> ReadPoses(const std::string& path, bool timed, ParseLine parse) {
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(path));
  Trajectory trajectory;
  trajectory.timed = timed;
  while (reader.Next()) {
    if (trajectory.size() == kMaxPoses) return reader.Error(absl::StrCat("more than ", kMaxPoses, " poses"));
    SEMMAP_ASSIGN_OR_RETURN(const StampedPose pose, parse(reader));
    if (timed && !trajectory.empty() && pose.timestamp < trajectory.poses.back().timestamp) {
      return reader.Error("the time is earlier than the one before");
    }
    trajectory.poses.push_back(pose);
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  if (trajectory.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": holds no poses"));
  return trajectory;
}

void AppendTum(const StampedPose& pose, std::string* text) {
  const Eigen::Vector3d& t = pose.map_from_camera.translation();
  Eigen::Quaterniond q = pose.map_from_camera.rotation();
  // q and -q are the same rotation; one of them is written, so that equal poses give equal text.
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  absl::StrAppendFormat(text, "%s %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", FormatSeconds(pose.timestamp),
                        t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

void AppendKitti(const StampedPose& pose, std::string* text) {
  const Eigen::Matrix4d m = pose.map_from_camera.Matrix();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      absl::StrAppendFormat(text, "%.17g%c", m(row, column), row == 2 && column == 3 ? '\n' : ' ');
    }
  }
}

}  // namespace

absl::StatusOr<Trajectory> ReadTumTrajectory(const std::string& path) {
  return ReadPoses(path, true, ParseTumLine);
}

absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& path) {
  return ReadPoses(path, false, ParseKittiLine);
}

absl::StatusOr<Trajectory> ReadTrajectory(const std::string& path, TrajectoryFormat format) {
  return format == TrajectoryFormat::kTum ? ReadTumTrajectory(path) : ReadKittiTrajectory(path);
}

absl::StatusOr<std::vector<TimestampNs>> ReadTimes(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(LineReader reader, LineReader::Open(path));
  std::vector<TimestampNs> times;
  while (reader.Next()) {
    const std::optional<TimestampNs> time = reader.Seconds(0);
    if (!time || reader.fields().size() != 1) return reader.Error("expected one time in seconds");
    if (!times.empty() && *time <= times.back())
      return reader.Error("the time is not later than the one before");
    if (times.size() == kMaxPoses) return reader.Error(absl::StrCat("more than ", kMaxPoses, " times"));
    times.push_back(*time);
  }
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return times;
}

absl::Status AttachTimes(const std::vector<TimestampNs>& times, Trajectory* trajectory) {
  if (times.size() < trajectory->size()) {
    return absl::InvalidArgumentError(
        absl::StrCat(times.size(), " times for ", trajectory->size(), " poses: each pose needs one"));
  }
  for (size_t i = 0; i < trajectory->size(); ++i) trajectory->poses[i].timestamp = times[i];
  trajectory->timed = true;
  return absl::OkStatus();
}

std::string FormatTrajectory(const Trajectory& trajectory, TrajectoryFormat format) {
  std::string text;
  for (const StampedPose& pose : trajectory.poses) {
    format == TrajectoryFormat::kTum ? AppendTum(pose, &text) : AppendKitti(pose, &text);
  }
  return text;
}

absl::Status WriteTrajectory(const std::string& path, const Trajectory& trajectory, TrajectoryFormat format) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream << FormatTrajectory(trajectory, format);
  stream.close();
  if (!stream) return absl::UnavailableError(absl::StrCat(path, ": cannot be written"));
  return absl::OkStatus();
}

}  // namespace semmap
