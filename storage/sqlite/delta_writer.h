#pragma once

#include "absl/status/status.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// MapStore::Apply inside the caller's transaction, which must be rolled back when this fails. `delta` was
// validated. Words are stored along when there is a wording (not null).
absl::Status WriteDelta(Connection& connection, MapId map, SessionId session, const MapDelta& delta,
                        size_t max_keypoints, const PlaceWording* wording);

// Changes of a hidden map that no session makes: a part of MapRewrite::changes. INVALID_ARGUMENT also when
// they add points; keyframes and frames that they add are passed over.
absl::Status WriteChanges(Connection& connection, MapId map, const MapDelta& changes);

}  // namespace semmap::storage::sqlite
