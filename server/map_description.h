#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "semmap/v1/map.pb.h"
#include "storage/map_store.h"

// What people say about a map, as requests carry it. Errors are FIELD_INVALID with the field's name.
namespace semmap::server {

absl::Status CheckDisplayName(const std::string& display_name);
absl::StatusOr<storage::Labels> ReadLabels(const v1::Map& map);
// An unset scale means 1; the source is "given", whatever the request says.
absl::StatusOr<storage::GeoAnchor> ReadAnchor(const v1::GeoAnchor& anchor);

}  // namespace semmap::server
