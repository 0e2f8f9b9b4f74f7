#include <algorithm>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/area_filter.h"
#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/keyframe_conversion.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "server/nearest.h"
#include "server/page_token.h"
#include "server/pose_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr int kStandardPage = 1000;
constexpr int kMaxPage = 10000;

// What the token is bound to: the request without page size and token.
std::string ScopeOf(v1::QueryKeyFramesRequest request) {
  request.clear_page_size();
  request.clear_page_token();
  return "QueryKeyFrames" + request.SerializeAsString();
}

absl::StatusOr<storage::KeyFrameQuery> ReadQuery(const ServiceContext& context, const storage::MapInfo& map,
                                                 const v1::QueryKeyFramesRequest& request) {
  storage::KeyFrameQuery query;
  SEMMAP_ASSIGN_OR_RETURN(const std::string cursor, ReadPageToken(ScopeOf(request), request.page_token()));
  uint64_t after = 0;
  if (!cursor.empty() && absl::SimpleAtoi(cursor, &after)) query.after = KeyFrameId(after);
  if (request.has_time()) {
    SEMMAP_ASSIGN_OR_RETURN(query.time, FromProto(request.time()));
  }
  if (!request.session().empty()) {
    SEMMAP_ASSIGN_OR_RETURN(query.session, FindSession(context, map, request.session()));
  }
  return query;
}

// One page of entries, and one more if there is one.
absl::StatusOr<std::vector<storage::KeyFrameEntry>> ReadEntries(const ServiceContext& context,
                                                                storage::MapId map,
                                                                const storage::KeyFrameQuery& query,
                                                                const AreaFilter& area, size_t page) {
  std::vector<storage::KeyFrameEntry> entries;
  const auto visit = [&](const storage::KeyFrameEntry& entry) {
    if (area.Contains(entry.record.map_from_camera.translation(), entry.record.id.value())) {
      entries.push_back(entry);
    }
    return entries.size() <= page;
  };
  SEMMAP_RETURN_IF_ERROR(FromStore(context.store->ForEachKeyFrame(map, query, visit)));
  return entries;
}

absl::StatusOr<v1::QueryKeyFramesResponse> MakeResponse(const ServiceContext& context,
                                                        const storage::MapInfo& map,
                                                        const std::vector<storage::KeyFrameEntry>& entries,
                                                        size_t page, const std::string& scope) {
  v1::QueryKeyFramesResponse response;
  response.set_map_version(map.version);
  SessionNames names(context.store, map.id);
  for (size_t i = 0; i < std::min(entries.size(), page); ++i) {
    SEMMAP_ASSIGN_OR_RETURN(const std::string name, names.NameOf(entries[i].session));
    *response.add_keyframes() = ToProto(entries[i], name);
  }
  if (entries.size() > page) {
    response.set_next_page_token(MakePageToken(scope, absl::StrCat(entries[page - 1].record.id.value())));
  }
  return response;
}

}  // namespace

absl::StatusOr<v1::QueryKeyFramesResponse> QueryKeyFrames(const ServiceContext& context,
                                                          const v1::QueryKeyFramesRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "map", request.map()));
  SEMMAP_ASSIGN_OR_RETURN(const int page, ReadPageSize(request.page_size(), kStandardPage, kMaxPage));
  SEMMAP_ASSIGN_OR_RETURN(storage::KeyFrameQuery query, ReadQuery(context, map, request));
  SEMMAP_ASSIGN_OR_RETURN(AreaFilter area, FromProto(request.area()));
  SEMMAP_RETURN_IF_ERROR(ResolveNearest(*context.store, map.id, query, &area));
  query.box = area.box;
  SEMMAP_ASSIGN_OR_RETURN(const auto entries,
                          ReadEntries(context, map.id, query, area, static_cast<size_t>(page)));
  return MakeResponse(context, map, entries, static_cast<size_t>(page), ScopeOf(request));
}

}  // namespace semmap::server
