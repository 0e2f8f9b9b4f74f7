#pragma once

#include "absl/status/status.h"
#include "storage/byte_buffer.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// The rows of what keyframes look like. Writers run inside the caller's transaction; `buffer` is for scratch.
namespace semmap::storage::sqlite {

// Replaces what the keyframe had.
absl::Status WriteWords(Connection& connection, MapId map, uint64_t vocabulary, const KeyFrameWords& keyframe,
                        ByteWriter* buffer);
// Adds to what the keyframe has; when it has none by this vocabulary, it has none afterwards.
absl::Status AddWords(Connection& connection, MapId map, uint64_t vocabulary, KeyFrameWords keyframe,
                      ByteWriter* buffer);
absl::Status EraseWords(Connection& connection, MapId map, KeyFrameId keyframe);

}  // namespace semmap::storage::sqlite
