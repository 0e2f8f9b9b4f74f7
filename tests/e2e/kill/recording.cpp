#include "recording.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <thread>

#include "client/cli/frame_message.h"
#include "client/cli/rig_conversion.h"
#include "client/image.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"
#include "tests/support/textured_room.h"

namespace semmap::kill_test {
namespace {

constexpr int kRoundFrames = 84;
constexpr int kFramesBehindTheRound = 26;
constexpr double kRadius = 1.2;
constexpr double kCentreZ = 8;
constexpr int64_t kFrameNs = 100'000'000;

SE3 PoseOnCircle(int index) {
  const double angle = 2 * std::numbers::pi * index / kRoundFrames;
  return SE3(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
             {-kRadius * std::cos(angle), 0, kCentreZ + kRadius * std::sin(angle)});
}

absl::Status DrawFrame(const testing::TexturedRoom& room, int index, v1::Frame* frame) {
  const CameraRig rig = testing::SmallRig(SensorType::kStereo);
  const SE3 left_from_right(Eigen::Quaterniond::Identity(), {rig.baseline_m, 0, 0});
  const SE3 pose = PoseOnCircle(index);
  frame->set_sequence(static_cast<uint64_t>(index) + 1);
  frame->set_timestamp_ns(index * kFrameNs);
  SEMMAP_ASSIGN_OR_RETURN(*frame->mutable_image(), client::RawImage(room.Render(rig.camera, pose)));
  SEMMAP_ASSIGN_OR_RETURN(*frame->mutable_right(),
                          client::RawImage(room.Render(rig.camera, pose * left_from_right)));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Recording> ReadRecording(const std::string& source, SensorType sensor, size_t max_frames) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<client::FrameSource> reader,
                          client::OpenSource(source, {sensor, ""}));
  Recording recording;
  recording.rig = client::ToProto(reader->rig());
  while (recording.frames.size() < max_frames) {
    SEMMAP_ASSIGN_OR_RETURN(std::optional<client::SourceFrame> frame, reader->Next());
    if (!frame) break;
    SEMMAP_ASSIGN_OR_RETURN(v1::Frame message, client::FrameMessage(*std::move(frame)));
    recording.frames.push_back(std::move(message));
  }
  if (recording.frames.empty()) return absl::InvalidArgumentError(source + " has no frames");
  return recording;
}

absl::StatusOr<Recording> DrawRoundTrip() {
  const testing::TexturedRoom room(3);
  Recording recording;
  recording.rig = client::ToProto(testing::SmallRig(SensorType::kStereo));
  recording.frames.resize(kRoundFrames + kFramesBehindTheRound);
  const auto count = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::vector<absl::Status> results(static_cast<size_t>(count));
  std::vector<std::thread> painters;
  for (int painter = 0; painter < count; ++painter) {
    painters.emplace_back([&, painter] {
      for (int i = painter; i < static_cast<int>(recording.frames.size()); i += count) {
        results[static_cast<size_t>(painter)].Update(
            DrawFrame(room, i, &recording.frames[static_cast<size_t>(i)]));
      }
    });
  }
  for (std::thread& painter : painters) painter.join();
  for (const absl::Status& result : results) SEMMAP_RETURN_IF_ERROR(result);
  return recording;
}

}  // namespace semmap::kill_test
