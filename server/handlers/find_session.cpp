#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

absl::StatusOr<storage::SessionId> FindSession(const ServiceContext& context, const storage::MapInfo& map,
                                               const std::string& name) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseSessionName("session", name));
  const auto session = context.store->GetSession(id);
  if (session.ok() && session->map == map.id) return session->id;
  const bool failed = !session.ok() && session.status().code() != absl::StatusCode::kNotFound;
  if (failed) return FromStore(session.status());
  return Error(v1::ERROR_REASON_SESSION_NOT_FOUND, "the map has no such session", {{"session", id}});
}

}  // namespace semmap::server
