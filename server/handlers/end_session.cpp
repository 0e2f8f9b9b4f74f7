#include "server/error_reasons.h"
#include "server/handlers/session_handlers.h"
#include "server/names.h"

namespace semmap::server {

void EndSession(const ServiceContext& context, const v1::EndSessionRequest& request,
                std::function<void(absl::StatusOr<v1::Session>)> done) {
  const auto id = ParseSessionName("name", request.name());
  if (!id.ok()) {
    done(id.status());
    return;
  }
  const auto session = context.sessions->Find(*id);
  if (session == nullptr) {
    v1::GetSessionRequest get;
    get.set_name(request.name());
    done(GetSession(context, get));
    return;
  }
  session->End(v1::SESSION_END_REASON_OPERATOR,
               Error(v1::ERROR_REASON_SESSION_ENDED_BY_OPERATOR, "an operator ended the session"));
  session->WhenOver([done = std::move(done)](const v1::Session& last) { done(last); });
}

}  // namespace semmap::server
