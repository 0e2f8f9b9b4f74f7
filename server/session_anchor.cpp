#include "server/session_anchor.h"

#include <vector>

#include <spdlog/spdlog.h>

#include "server/anchor_fit.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

absl::StatusOr<std::vector<GnssMatch>> MatchFixes(storage::MapStore& store, storage::MapId map,
                                                  storage::SessionId session, const GnssTrack& track) {
  std::vector<GnssMatch> matches;
  // Both come in order of sequences.
  auto fix = track.samples().begin();
  const auto end = track.samples().end();
  const auto visit = [&](const storage::TrajectoryPose& pose) {
    while (fix != end && fix->sequence < pose.sequence) ++fix;
    if (fix != end && fix->sequence == pose.sequence) matches.push_back({*fix, pose.map_from_camera});
    return fix != end;
  };
  storage::TrajectoryQuery query;
  query.session = session;
  SEMMAP_RETURN_IF_ERROR(store.ForEachTrajectoryPose(map, query, visit));
  return matches;
}

}  // namespace

absl::Status AnchorByFixes(storage::MapStore& store, storage::MapId map, storage::SessionId session,
                           const GnssTrack& track) {
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo info, store.GetMap(map));
  if (info.anchor.has_value()) return absl::OkStatus();
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<GnssMatch> matches, MatchFixes(store, map, session, track));
  SEMMAP_ASSIGN_OR_RETURN(const storage::GeoAnchor anchor, FitAnchor(matches, info.scale_known));
  SEMMAP_RETURN_IF_ERROR(store.SetAnchor(map, anchor));
  spdlog::info("map anchored map={} fixes={} rms_m={:.2f} scale={:.4f}", info.name, matches.size(),
               anchor.rms_error_m, anchor.enu_from_map.scale);
  return absl::OkStatus();
}

}  // namespace semmap::server
