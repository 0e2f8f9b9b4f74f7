#include <optional>

#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

void AppendPose(const storage::TrajectoryPose& pose, v1::TrajectoryColumns* out) {
  out->add_sequences(pose.sequence);
  out->add_timestamps_ns(pose.timestamp);
  const Eigen::Vector3d& t = pose.map_from_camera.translation();
  const Eigen::Quaterniond& q = pose.map_from_camera.rotation();
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) out->add_poses(value);
}

class TrajectorySource : public ChunkSource<v1::GetTrajectoryResponse> {
 public:
  TrajectorySource(const ServiceContext& context, storage::MapId map, storage::TrajectoryQuery query)
      : context_(context), map_(map), query_(query) {}

  absl::StatusOr<bool> Next(v1::GetTrajectoryResponse* response) override {
    const auto map = context_.store->GetMap(map_);
    if (!map.ok()) return FromStore(map.status());
    response->set_map_version(map->version);
    v1::TrajectoryColumns* columns = response->mutable_trajectory();
    std::optional<storage::SessionId> session;
    const auto visit = [&](const storage::TrajectoryPose& pose) {
      // One message, one session: the next one begins behind the last pose taken.
      if (session.has_value() && *session != pose.session) return false;
      session = pose.session;
      AppendPose(pose, columns);
      query_.after = {pose.session, pose.sequence};
      return columns->sequences_size() < context_.config.query_chunk;
    };
    const storage::TrajectoryQuery query = query_;
    SEMMAP_RETURN_IF_ERROR(FromStore(context_.store->ForEachTrajectoryPose(map_, query, visit)));
    if (!session.has_value()) return false;
    SEMMAP_ASSIGN_OR_RETURN(*response->mutable_session(), NameOf(*session));
    return true;
  }

 private:
  absl::StatusOr<std::string> NameOf(storage::SessionId session) {
    const auto info = context_.store->GetSession(map_, session);
    if (!info.ok()) return FromStore(info.status());
    return SessionName(info->name);
  }

  const ServiceContext& context_;
  const storage::MapId map_;
  storage::TrajectoryQuery query_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<ChunkSource<v1::GetTrajectoryResponse>>> GetTrajectory(
    const ServiceContext& context, const v1::GetTrajectoryRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "map", request.map()));
  storage::TrajectoryQuery query;
  if (request.has_time()) {
    SEMMAP_ASSIGN_OR_RETURN(query.time, FromProto(request.time()));
  }
  if (!request.session().empty()) {
    SEMMAP_ASSIGN_OR_RETURN(query.session, FindSession(context, map, request.session()));
  }
  return std::make_unique<TrajectorySource>(context, map.id, query);
}

}  // namespace semmap::server
