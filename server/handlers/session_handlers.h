#pragma once

#include <functional>

#include "absl/status/statusor.h"
#include "semmap/v1/session_service.pb.h"
#include "server/service_context.h"

// SessionService without the stream, one function and file for each call; as map_handlers.h.
namespace semmap::server {

absl::StatusOr<v1::Session> GetSession(const ServiceContext& context, const v1::GetSessionRequest& request);
absl::StatusOr<v1::ListSessionsResponse> ListSessions(const ServiceContext& context,
                                                      const v1::ListSessionsRequest& request);

// Ending takes as long as the session's waiting frames: `done` is called, once, when everything is stored.
void EndSession(const ServiceContext& context, const v1::EndSessionRequest& request,
                std::function<void(absl::StatusOr<v1::Session>)> done);

}  // namespace semmap::server
