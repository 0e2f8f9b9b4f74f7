#include "storage/sqlite/whole_map.h"

#include "slam/common/status_macros.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/session_rows.h"

namespace semmap::storage::sqlite {
namespace {

absl::Status ReadAllPoints(Connection& connection, MapId map, MapReader* reader) {
  absl::Status status;
  SEMMAP_RETURN_IF_ERROR(VisitPoints(connection, map, {}, [&](const MapPointRecord& point) {
    status = reader->OnPoint(point);
    return status.ok();
  }));
  return status;
}

absl::Status ReadAllKeyFrames(Connection& connection, MapId map, MapReader* reader) {
  KeyFrameQuery query;
  query.with_features = true;
  absl::Status status;
  SEMMAP_RETURN_IF_ERROR(VisitKeyFrames(connection, map, query, [&](const KeyFrameEntry& keyframe) {
    auto observations = ReadObservations(connection, map, keyframe.record.id);
    status =
        observations.ok() ? reader->OnKeyFrame(keyframe, *std::move(observations)) : observations.status();
    return status.ok();
  }));
  return status;
}

}  // namespace

absl::Status ReadWholeMap(Connection& connection, MapId map, MapReader* reader) {
  SEMMAP_ASSIGN_OR_RETURN(const MapInfo info, ReadMap(connection, map));
  SEMMAP_RETURN_IF_ERROR(reader->OnMap(info));
  SEMMAP_ASSIGN_OR_RETURN(const auto sessions, ReadSessions(connection, map, SessionId(), 0));
  for (const SessionInfo& session : sessions) SEMMAP_RETURN_IF_ERROR(reader->OnSession(session));
  SEMMAP_RETURN_IF_ERROR(ReadAllPoints(connection, map, reader));
  return ReadAllKeyFrames(connection, map, reader);
}

}  // namespace semmap::storage::sqlite
