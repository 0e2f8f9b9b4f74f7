#include <optional>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/session_handlers.h"
#include "server/names.h"
#include "server/page_token.h"
#include "server/session_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

// Maps looked at with one question to the store.
constexpr size_t kMapBatch = 64;
constexpr size_t kSessionBatch = 256;

std::string ScopeOf(v1::ListSessionsRequest request) {
  request.clear_page_size();
  request.clear_page_token();
  return "ListSessions" + request.SerializeAsString();
}

// Walks over the sessions of one map or of all, from behind a cursor "map/session number", until a page is
// full.
class Walker {
 public:
  Walker(const ServiceContext& context, const v1::ListSessionsRequest& request, int page)
      : context_(context), request_(request), page_(page) {}

  absl::Status SetCursor(const std::string& cursor) {
    if (cursor.empty()) return absl::OkStatus();
    const std::vector<std::string> parts = absl::StrSplit(cursor, '/');
    uint64_t number = 0;
    if (parts.size() != 2 || !absl::SimpleAtoi(parts[1], &number)) {
      return Error(v1::ERROR_REASON_PAGE_TOKEN_INVALID, "page_token is damaged");
    }
    cursor_map_ = parts[0];
    cursor_session_ = storage::SessionId(number);
    return absl::OkStatus();
  }

  absl::StatusOr<v1::ListSessionsResponse> Walk() {
    if (!request_.map().empty()) {
      SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context_, "map", request_.map()));
      SEMMAP_RETURN_IF_ERROR(WalkMap(map));
      return std::move(response_);
    }
    // The map that the last page broke off in comes first, then those behind it.
    if (!cursor_map_.empty()) {
      const auto map = context_.store->GetMap(cursor_map_);
      if (map.ok()) SEMMAP_RETURN_IF_ERROR(WalkMap(*map));
    }
    SEMMAP_RETURN_IF_ERROR(WalkMapsAfter(cursor_map_));
    return std::move(response_);
  }

 private:
  absl::Status WalkMapsAfter(std::string after) {
    while (!full_) {
      const auto maps = context_.store->ListMaps({after, kMapBatch});
      if (!maps.ok()) return FromStore(maps.status());
      for (const storage::MapInfo& map : *maps) {
        SEMMAP_RETURN_IF_ERROR(WalkMap(map));
        if (full_) return absl::OkStatus();
      }
      if (maps->size() < kMapBatch) return absl::OkStatus();
      after = maps->back().name;
    }
    return absl::OkStatus();
  }

  absl::Status WalkMap(const storage::MapInfo& map) {
    storage::SessionId after = map.name == cursor_map_ ? cursor_session_ : storage::SessionId();
    while (!full_) {
      const auto sessions = context_.store->ListSessions(map.id, after, kSessionBatch);
      if (!sessions.ok()) return FromStore(sessions.status());
      for (const storage::SessionInfo& session : *sessions) Add(map, session);
      if (sessions->size() < kSessionBatch) return absl::OkStatus();
      after = sessions->back().id;
    }
    return absl::OkStatus();
  }

  void Add(const storage::MapInfo& map, const storage::SessionInfo& session) {
    if (full_) return;
    if (!request_.vehicle_id().empty() && session.vehicle_id != request_.vehicle_id()) return;
    const auto known = context_.sessions->Describe(session.name);
    v1::Session proto = known.has_value() ? *known : ToProto(session, map.name);
    const bool any_state = request_.state() == v1::SESSION_STATE_UNSPECIFIED;
    if (!any_state && proto.state() != request_.state()) return;
    if (response_.sessions_size() == page_) {
      full_ = true;
      response_.set_next_page_token(MakePageToken(ScopeOf(request_), last_cursor_));
      return;
    }
    *response_.add_sessions() = std::move(proto);
    last_cursor_ = absl::StrCat(map.name, "/", session.id.value());
  }

  const ServiceContext& context_;
  const v1::ListSessionsRequest& request_;
  const int page_;
  std::string cursor_map_;
  storage::SessionId cursor_session_;
  std::string last_cursor_;
  bool full_ = false;
  v1::ListSessionsResponse response_;
};

}  // namespace

absl::StatusOr<v1::ListSessionsResponse> ListSessions(const ServiceContext& context,
                                                      const v1::ListSessionsRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const int page, ReadPageSize(request.page_size()));
  SEMMAP_ASSIGN_OR_RETURN(const std::string cursor, ReadPageToken(ScopeOf(request), request.page_token()));
  if (!request.vehicle_id().empty()) SEMMAP_RETURN_IF_ERROR(ValidateId("vehicle_id", request.vehicle_id()));
  Walker walker(context, request, page);
  SEMMAP_RETURN_IF_ERROR(walker.SetCursor(cursor));
  return walker.Walk();
}

}  // namespace semmap::server
