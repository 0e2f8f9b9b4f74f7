#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "server/page_token.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr char kScope[] = "ListMaps";

}  // namespace

absl::StatusOr<v1::ListMapsResponse> ListMaps(const ServiceContext& context,
                                              const v1::ListMapsRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const int page, ReadPageSize(request.page_size()));
  SEMMAP_ASSIGN_OR_RETURN(const std::string after, ReadPageToken(kScope, request.page_token()));
  // One more than asked for tells whether there is another page.
  const auto maps = context.store->ListMaps({after, static_cast<size_t>(page) + 1});
  if (!maps.ok()) return FromStore(maps.status());
  v1::ListMapsResponse response;
  for (const storage::MapInfo& map : *maps) {
    if (response.maps_size() == page) {
      response.set_next_page_token(MakePageToken(kScope, (*maps)[static_cast<size_t>(page) - 1].name));
      break;
    }
    *response.add_maps() = ToProto(map);
  }
  return response;
}

}  // namespace semmap::server
