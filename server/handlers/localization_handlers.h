#pragma once

#include "absl/status/statusor.h"
#include "semmap/v1/localization_service.pb.h"
#include "server/service_context.h"
#include "slam/pipeline/map_localizer.h"
#include "slam/pipeline/map_snapshot.h"

// LocalizationService; as map_handlers.h. A call has two parts, between which the map is loaded.
namespace semmap::server {

// What a request asks for, checked.
struct RelocalizeTask {
  storage::MapInfo map;
  CameraRig rig;
  PlacePrior prior;
};

// All that a request can be refused for before the map and the images are looked at.
absl::StatusOr<RelocalizeTask> PrepareRelocalize(const ServiceContext& context,
                                                 const v1::RelocalizeRequest& request);

// Decodes the images and looks for them in the map. Takes the time of a frame and of some ten places. Where
// sessions segment their frames, an image that brings no class mask is segmented, too.
absl::StatusOr<v1::RelocalizeResponse> Relocalize(const ServiceContext& context,
                                                  const v1::RelocalizeRequest& request,
                                                  const RelocalizeTask& task, const MapSnapshot& map);

}  // namespace semmap::server
