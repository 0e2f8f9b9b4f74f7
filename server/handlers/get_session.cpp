#include "server/error_reasons.h"
#include "server/handlers/session_handlers.h"
#include "server/names.h"
#include "server/session_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

absl::StatusOr<v1::Session> GetSession(const ServiceContext& context, const v1::GetSessionRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseSessionName("name", request.name()));
  if (const auto known = context.sessions->Describe(id)) return *known;
  const auto session = context.store->GetSession(id);
  if (session.status().code() == absl::StatusCode::kNotFound) {
    return Error(v1::ERROR_REASON_SESSION_NOT_FOUND, "there is no " + request.name(), {{"session", id}});
  }
  if (!session.ok()) return FromStore(session.status());
  const auto map = context.store->GetMap(session->map);
  if (!map.ok()) return FromStore(map.status());
  return ToProto(*session, map->name);
}

}  // namespace semmap::server
