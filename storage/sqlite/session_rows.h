#pragma once

#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// The rows of sessions. Writers run inside the caller's transaction.
namespace semmap::storage::sqlite {

absl::StatusOr<SessionId> InsertSession(Connection& connection, const NewSession& session);
absl::StatusOr<SessionInfo> ReadSession(Connection& connection, MapId map, SessionId session);
absl::StatusOr<SessionInfo> ReadSession(Connection& connection, std::string_view name);
absl::StatusOr<std::vector<SessionInfo>> ReadSessions(Connection& connection, MapId map, SessionId after,
                                                      size_t limit);
absl::Status UpdateCounters(Connection& connection, MapId map, SessionId session,
                            const SessionCounters& counters);
// FAILED_PRECONDITION when it has ended before.
absl::Status CloseSession(Connection& connection, MapId map, SessionId session, TimestampNs ended_at);

// What a delta did to its session.
struct SessionProgress {
  uint64_t delta_version = 0;
  uint64_t stored_frames = 0;
  std::optional<uint64_t> last_durable_sequence;
};
// Where the session stands before a delta. NOT_FOUND for no such session, FAILED_PRECONDITION when it has
// ended.
absl::StatusOr<SessionProgress> ReadProgress(Connection& connection, MapId map, SessionId session);
absl::Status WriteProgress(Connection& connection, MapId map, SessionId session,
                           const SessionProgress& progress);

}  // namespace semmap::storage::sqlite
