#include "server/session_conversion.h"

#include "server/names.h"
#include "server/pose_conversion.h"
#include "server/rig_conversion.h"

namespace semmap::server {
namespace {

v1::TrackingState ToProto(TrackingState state) {
  switch (state) {
    case TrackingState::kTracking:
      return v1::TRACKING_STATE_TRACKING;
    case TrackingState::kLost:
      return v1::TRACKING_STATE_LOST;
    default:
      return v1::TRACKING_STATE_INITIALIZING;
  }
}

v1::ProcessingTimes ToProto(const StageTimes& times) {
  v1::ProcessingTimes proto;
  proto.set_extract_ms(times.extract_ms);
  proto.set_stereo_ms(times.stereo_ms);
  proto.set_classify_ms(times.classify_ms);
  proto.set_match_ms(times.match_ms);
  proto.set_optimize_ms(times.optimize_ms);
  proto.set_track_ms(times.total_ms);
  return proto;
}

}  // namespace

v1::RelocalizeResult ToProto(LocalizationFailure failure) {
  switch (failure) {
    case LocalizationFailure::kNone:
      return v1::RELOCALIZE_RESULT_FOUND;
    case LocalizationFailure::kNoCandidates:
      return v1::RELOCALIZE_RESULT_NO_CANDIDATES;
    case LocalizationFailure::kTooFewMatches:
      return v1::RELOCALIZE_RESULT_TOO_FEW_MATCHES;
    case LocalizationFailure::kDegeneratePose:
      return v1::RELOCALIZE_RESULT_DEGENERATE_POSE;
    case LocalizationFailure::kTooFewInliers:
      return v1::RELOCALIZE_RESULT_BELOW_THRESHOLD;
  }
  return v1::RELOCALIZE_RESULT_UNSPECIFIED;
}

google::protobuf::Timestamp ToTimestamp(TimestampNs unix_ns) {
  google::protobuf::Timestamp proto;
  proto.set_seconds(unix_ns / 1'000'000'000);
  proto.set_nanos(static_cast<int32_t>(unix_ns % 1'000'000'000));
  return proto;
}

v1::FrameEstimate ToProto(const FrameResult& result, double queue_ms, double decode_ms) {
  v1::FrameEstimate proto;
  proto.set_sequence(result.sequence);
  proto.set_timestamp_ns(result.timestamp);
  proto.set_state(ToProto(result.state));
  if (result.map_from_camera.has_value()) {
    *proto.mutable_map_from_camera() = ToProto(*result.map_from_camera);
    proto.set_reference_frame(result.in_own_piece ? v1::REFERENCE_FRAME_SESSION : v1::REFERENCE_FRAME_MAP);
    if (!result.covariance.isZero(0)) *proto.mutable_covariance() = ToProto(result.covariance);
  }
  proto.set_inliers(result.inliers);
  if (result.failure != LocalizationFailure::kNone) proto.set_lost_because(ToProto(result.failure));
  proto.set_keyframe(result.is_keyframe);
  proto.set_map_version(result.map_version);
  *proto.mutable_times() = ToProto(result.times);
  proto.mutable_times()->set_queue_ms(queue_ms);
  proto.mutable_times()->set_decode_ms(decode_ms);
  return proto;
}

v1::Session ToProto(const storage::SessionInfo& session, const std::string& map_id) {
  v1::Session proto;
  proto.set_name(SessionName(session.name));
  proto.set_vehicle_id(session.vehicle_id);
  proto.set_map(MapName(map_id));
  *proto.mutable_rig() = ToProto(session.rig);
  *proto.mutable_create_time() = ToTimestamp(session.started_at);
  if (session.ended_at.has_value()) {
    proto.set_state(v1::SESSION_STATE_FINISHED);
    *proto.mutable_end_time() = ToTimestamp(*session.ended_at);
  } else {
    proto.set_state(v1::SESSION_STATE_ABANDONED);
    proto.set_end_reason(v1::SESSION_END_REASON_CRASH);
  }
  proto.mutable_statistics()->set_frames_received(session.counters.frames_received);
  proto.mutable_statistics()->set_frames_tracked(session.counters.frames_tracked);
  proto.set_last_acknowledged_sequence(session.last_durable_sequence.value_or(0));
  return proto;
}

}  // namespace semmap::server
