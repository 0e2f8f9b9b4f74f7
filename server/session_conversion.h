#pragma once

#include "google/protobuf/timestamp.pb.h"
#include "semmap/v1/localization_service.pb.h"
#include "semmap/v1/session.pb.h"
#include "slam/pipeline/frame.h"
#include "storage/map_store.h"

namespace semmap::server {

google::protobuf::Timestamp ToTimestamp(TimestampNs unix_ns);

v1::RelocalizeResult ToProto(LocalizationFailure failure);

v1::FrameEstimate ToProto(const FrameResult& result, double queue_ms, double decode_ms);

// A session of which only the store knows: one that is over, or that a crash cut off.
v1::Session ToProto(const storage::SessionInfo& session, const std::string& map_id);

}  // namespace semmap::server
