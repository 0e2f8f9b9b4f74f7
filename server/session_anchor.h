#pragma once

#include "absl/status/status.h"
#include "server/gnss_track.h"
#include "storage/map_store.h"

namespace semmap::server {

// Gives a map that has no anchor one, from the fixes of a session and its stored trajectory. OK also when the
// map has one; FitAnchor's FAILED_PRECONDITION when the fixes do not suffice; the store's.
absl::Status AnchorByFixes(storage::MapStore& store, storage::MapId map, storage::SessionId session,
                           const GnssTrack& track);

}  // namespace semmap::server
