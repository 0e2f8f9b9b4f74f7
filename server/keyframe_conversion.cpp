#include "server/keyframe_conversion.h"

#include "server/error_reasons.h"
#include "server/names.h"
#include "server/pose_conversion.h"

namespace semmap::server {

v1::KeyFrame ToProto(const storage::KeyFrameEntry& entry, const std::string& session_name) {
  v1::KeyFrame proto;
  proto.set_id(entry.record.id.value());
  proto.set_session(SessionName(session_name));
  proto.set_sequence(entry.record.sequence);
  proto.set_timestamp_ns(entry.record.timestamp);
  *proto.mutable_map_from_camera() = ToProto(entry.record.map_from_camera);
  proto.set_parent_id(entry.record.parent.value());
  proto.set_keypoint_count(static_cast<int32_t>(entry.keypoint_count));
  proto.set_observation_count(static_cast<int32_t>(entry.observation_count));
  return proto;
}

absl::StatusOr<std::string> SessionNames::NameOf(storage::SessionId session) {
  std::string& name = names_[session];
  if (name.empty()) {
    const auto info = store_->GetSession(map_, session);
    if (!info.ok()) return FromStore(info.status());
    name = info->name;
  }
  return name;
}

}  // namespace semmap::server
