#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "semmap/v1/map_service.pb.h"
#include "server/artifacts.h"
#include "server/output_file.h"
#include "server/service_context.h"
#include "slam/common/sha256.h"

namespace semmap::server {

// A map file that arrives in pieces and becomes a map when it is whole. What has arrived is deleted with the
// object. Not thread-safe.
class MapUpload {
 public:
  // NAME_INVALID, FIELD_INVALID, MAP_EXISTS, STORE_UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<MapUpload>> Begin(const ServiceContext& context,
                                                          const v1::ImportMapHeader& header);

  // FIELD_INVALID, FILES_TOO_LARGE, STORE_UNAVAILABLE.
  absl::Status Append(std::string_view chunk);
  // That was all: starts the operation. CHECKSUM_MISMATCH. Last call.
  absl::StatusOr<v1::Operation> Finish();

 private:
  MapUpload(const ServiceContext& context, v1::ImportMapHeader header, std::string map_id,
            std::unique_ptr<PendingFile> file);

  const ServiceContext& context_;
  const v1::ImportMapHeader header_;
  const std::string map_id_;
  std::shared_ptr<PendingFile> file_;
  OutputFile output_;
  Sha256 sha256_;
};

}  // namespace semmap::server
