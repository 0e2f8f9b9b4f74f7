#include "server/map_upload.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "server/error_reasons.h"
#include "server/handlers/start_operation.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr const char* kMethod = "ImportMap";
constexpr size_t kMaxChunk = 1 << 20;
constexpr size_t kSha256Bytes = 32;

absl::Status MapExists(const std::string& map_id) {
  return Error(v1::ERROR_REASON_MAP_EXISTS, MapName(map_id) + " exists", {{"map", map_id}});
}

absl::StatusOr<std::unique_ptr<google::protobuf::Message>> Import(const ServiceContext& context,
                                                                  const PendingFile& file,
                                                                  const std::string& map_id,
                                                                  OperationProgress& progress) {
  const auto map = context.store->ImportMap(file.path(), map_id, context.wall_clock(), [&](double share) {
    progress.Report(share);
    return !progress.CancelRequested();
  });
  if (absl::IsCancelled(map.status())) return map.status();
  if (absl::IsAlreadyExists(map.status())) return MapExists(map_id);
  if (absl::IsInvalidArgument(map.status())) return WithReason(map.status(), v1::ERROR_REASON_FILE_INVALID);
  if (!map.ok()) return FromStore(map.status());
  spdlog::info("map imported map={} keyframes={} points={}", map_id, map->keyframe_count, map->point_count);
  return std::make_unique<v1::Map>(ToProto(*map));
}

}  // namespace

MapUpload::MapUpload(const ServiceContext& context, v1::ImportMapHeader header, std::string map_id,
                     std::unique_ptr<PendingFile> file)
    : context_(context),
      header_(std::move(header)),
      map_id_(std::move(map_id)),
      file_(std::move(file)),
      output_(file_.get()) {}

absl::StatusOr<std::unique_ptr<MapUpload>> MapUpload::Begin(const ServiceContext& context,
                                                            const v1::ImportMapHeader& header) {
  SEMMAP_ASSIGN_OR_RETURN(std::string map_id, ParseMapName("header.name", header.name()));
  if (header.format() != v1::MAP_FILE_FORMAT_SEMMAP) {
    return FieldInvalid("header.format", "must be MAP_FILE_FORMAT_SEMMAP");
  }
  if (!header.sha256().empty() && header.sha256().size() != kSha256Bytes) {
    return FieldInvalid("header.sha256", "must be 32 bytes");
  }
  // Told before all is sent, unless it is there because this request was sent before.
  const bool known = context.requests->Find(kMethod, header.request_id()).has_value();
  if (!known && context.store->GetMap(map_id).ok()) return MapExists(map_id);
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<PendingFile> file, context.artifacts->Begin());
  return std::unique_ptr<MapUpload>(new MapUpload(context, header, std::move(map_id), std::move(file)));
}

absl::Status MapUpload::Append(std::string_view chunk) {
  if (chunk.size() > kMaxChunk) return FieldInvalid("chunk", "must be at most 1 MiB");
  sha256_.Update(chunk);
  return output_.Append(chunk);
}

absl::StatusOr<v1::Operation> MapUpload::Finish() {
  SEMMAP_RETURN_IF_ERROR(output_.Close());
  if (!header_.sha256().empty() && sha256_.Finish() != header_.sha256()) {
    return Error(v1::ERROR_REASON_CHECKSUM_MISMATCH,
                 "the file that arrived is not the one that was announced");
  }
  return StartOperation(context_, kMethod, header_.request_id(), [&]() -> absl::StatusOr<v1::Operation> {
    return context_.operations->Start(
        v1::OPERATION_KIND_IMPORT, {map_id_},
        [context = context_, file = std::move(file_), map_id = map_id_](OperationProgress& progress) mutable {
          auto result = Import(context, *file, map_id, progress);
          file.reset();  // before anybody is told that it is done
          return result;
        });
  });
}

}  // namespace semmap::server
