#include "tests/bench/map_queries.h"

#include <memory>
#include <optional>
#include <utility>

#include "client/cli/frame_message.h"
#include "client/cli/rig_conversion.h"
#include "client/drive.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::bench {
namespace {

// How far the answer is off, and how far the picture is from the map.
absl::Status Judge(const QueryOptions& options, const MapTruth& map, const Trajectory& truth,
                   Answer* answer) {
  if (answer->frame >= truth.poses.size()) return absl::InvalidArgumentError("the truth is too short");
  const SE3& world_from_camera = truth.poses[answer->frame].map_from_camera;
  if (answer->found()) {
    const SE3 found = client::FromProto(answer->response.map_from_camera());
    answer->error = ComparePoses(world_from_camera, map.ToWorld(found));
    answer->local_error =
        ComparePoses(world_from_camera, map.ToWorldNear(found, world_from_camera.translation()));
  }
  answer->distance_m = map.Distance(world_from_camera);
  answer->in_map = map.Shows(world_from_camera, options.any_heading);
  return absl::OkStatus();
}

bool IsAskedFor(const QueryOptions& options, size_t frame) {
  const auto skip = static_cast<size_t>(options.skip);
  return frame >= skip && (frame - skip) % static_cast<size_t>(options.every) == 0;
}

absl::StatusOr<std::vector<Answer>> AskPictures(client::Client& client, const QueryOptions& options,
                                                client::FrameSource& source) {
  std::vector<Answer> answers;
  for (size_t frame = 0;; ++frame) {
    SEMMAP_ASSIGN_OR_RETURN(std::optional<client::SourceFrame> images, source.Next());
    if (!images) return answers;
    if (!IsAskedFor(options, frame)) continue;
    v1::RelocalizeRequest request;
    request.set_map(options.map);
    *request.mutable_rig() = client::ToProto(source.rig());
    SEMMAP_ASSIGN_OR_RETURN(*request.mutable_frame(), client::FrameMessage(*std::move(images)));
    Answer& answer = answers.emplace_back();
    answer.frame = frame;
    SEMMAP_ASSIGN_OR_RETURN(answer.response, client.Relocalize(request));
  }
}

Answer FromEstimate(const v1::FrameEstimate& estimate) {
  Answer answer;
  answer.frame = estimate.sequence() - 1;
  answer.response.set_result(estimate.lost_because());
  if (estimate.state() == v1::TRACKING_STATE_TRACKING) {
    answer.response.set_result(v1::RELOCALIZE_RESULT_FOUND);
    *answer.response.mutable_map_from_camera() = estimate.map_from_camera();
    *answer.response.mutable_covariance() = estimate.covariance();
  }
  answer.response.set_inliers(estimate.inliers());
  answer.response.set_map_version(estimate.map_version());
  answer.response.set_processing_ms(estimate.times().track_ms());
  return answer;
}

absl::StatusOr<std::vector<Answer>> AskByDriving(const std::shared_ptr<client::Connection>& connection,
                                                 const QueryOptions& options, client::FrameSource& source) {
  std::vector<Answer> answers;
  client::DriveObserver observer;
  // Finish returns when the last of them was told.
  observer.on_estimate = [&](const v1::FrameEstimate& estimate) {
    answers.push_back(FromEstimate(estimate));
  };
  client::DriveOptions drive_options;
  drive_options.vehicle_id = "visitor";
  drive_options.mode = v1::SESSION_MODE_LOCALIZE;
  drive_options.map = options.map;
  drive_options.rig = client::ToProto(source.rig());
  SEMMAP_ASSIGN_OR_RETURN(const auto drive, client::Drive::Start(connection, drive_options, observer));
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(std::optional<client::SourceFrame> images, source.Next());
    if (!images) break;
    SEMMAP_ASSIGN_OR_RETURN(v1::Frame frame, client::FrameMessage(*std::move(images)));
    SEMMAP_RETURN_IF_ERROR(drive->Send(std::move(frame)));
  }
  SEMMAP_RETURN_IF_ERROR(drive->Finish().status());
  return answers;
}

}  // namespace

absl::StatusOr<std::vector<Answer>> AskAll(client::Client& client,
                                           const std::shared_ptr<client::Connection>& connection,
                                           const QueryOptions& options, const MapTruth& map) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<client::FrameSource> source,
                          client::OpenSource(options.source, {options.sensor, ""}));
  SEMMAP_ASSIGN_OR_RETURN(const Trajectory truth, ReadKittiTrajectory(options.truth));
  SEMMAP_ASSIGN_OR_RETURN(std::vector<Answer> answers, options.drive
                                                           ? AskByDriving(connection, options, *source)
                                                           : AskPictures(client, options, *source));
  for (Answer& answer : answers) SEMMAP_RETURN_IF_ERROR(Judge(options, map, truth, &answer));
  return answers;
}

}  // namespace semmap::bench
