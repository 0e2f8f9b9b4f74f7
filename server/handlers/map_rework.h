#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "google/protobuf/message.h"
#include "server/operations.h"
#include "server/service_context.h"
#include "slam/pipeline/map_overlap.h"
#include "slam/pipeline/mapping_camera.h"
#include "storage/map_loader.h"

// What the operations that make a stored map over (merge, optimize, prune) have in common.
namespace semmap::server {

using OperationResult = Operations::Result;

// Reports the part [begin, end] of an operation's work as it is done; false when the operation was cancelled.
StepVisitor ReportPart(OperationProgress& progress, double begin, double end);
// CANCELLED when it was.
absl::Status CheckCancelled(const OperationProgress& progress);

// Whole maps, all together, may take so many bytes.
size_t MemoryLimit(const ServiceContext& context);
// MAP_TOO_LARGE for what does not fit into the limit; otherwise as FromStore.
absl::Status FromLoader(const absl::Status& status);
absl::StatusOr<storage::RestoredMap> LoadWholeMap(const ServiceContext& context, storage::MapId map);

MappingCamera CameraOf(const ServiceContext& context, const CameraRig& rig);

// Stores it and tells watchers. ETAG_MISMATCH when a map was changed meanwhile.
absl::StatusOr<storage::MapInfo> StoreRework(const ServiceContext& context,
                                             const storage::MapRewrite& rewrite, const StepVisitor& visit);

}  // namespace semmap::server
