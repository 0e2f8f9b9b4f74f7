#include "storage/sqlite/session_rows.h"

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/geometry_codec.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kTakeId[] =
    "UPDATE maps SET last_session_id = last_session_id + 1 WHERE map_id = ? RETURNING last_session_id";
constexpr char kInsert[] =
    "INSERT INTO sessions (map_id, session_id, name, vehicle_id, started_at, rig) VALUES (?, ?, ?, ?, ?, ?)";
#define SEMMAP_SESSION_COLUMNS                                                         \
  "map_id, session_id, name, vehicle_id, started_at, ended_at, rig, frames_received, " \
  "frames_tracked, stored_frames, last_durable_sequence, last_delta_version"
constexpr char kSelectById[] = "SELECT " SEMMAP_SESSION_COLUMNS
                               " FROM sessions WHERE map_id = ? AND session_id = ? AND name IS NOT NULL";
constexpr char kSelectByName[] = "SELECT " SEMMAP_SESSION_COLUMNS " FROM sessions WHERE name = ?";
constexpr char kSelectPage[] = "SELECT " SEMMAP_SESSION_COLUMNS
                               " FROM sessions WHERE map_id = ? AND session_id > ? AND name IS NOT NULL "
                               "ORDER BY session_id LIMIT ?";
#undef SEMMAP_SESSION_COLUMNS
constexpr char kUpdateCounters[] =
    "UPDATE sessions SET frames_received = ?, frames_tracked = ? "
    "WHERE map_id = ? AND session_id = ? AND name IS NOT NULL";
constexpr char kEnd[] = "UPDATE sessions SET ended_at = ? WHERE map_id = ? AND session_id = ?";
constexpr char kSelectProgress[] =
    "SELECT ended_at, last_delta_version, stored_frames, last_durable_sequence FROM sessions "
    "WHERE map_id = ? AND session_id = ? AND name IS NOT NULL";
constexpr char kUpdateProgress[] =
    "UPDATE sessions SET last_delta_version = ?, stored_frames = ?, last_durable_sequence = ? "
    "WHERE map_id = ? AND session_id = ?";

absl::Status NoSuchSession(MapId map, SessionId session) {
  return absl::NotFoundError(absl::StrCat("no session ", session.value(), " of map ", map.value()));
}

absl::StatusOr<SessionInfo> ReadRow(const Query& row) {
  SessionInfo session;
  session.map = row.IdAt<MapId>(0);
  session.id = row.IdAt<SessionId>(1);
  session.name = row.Text(2);
  session.vehicle_id = row.Text(3);
  session.started_at = row.Int(4);
  if (!row.IsNull(5)) session.ended_at = row.Int(5);
  SEMMAP_ASSIGN_OR_RETURN(session.rig, DecodeRig(row.Bytes(6)));
  session.counters = {row.Unsigned(7), row.Unsigned(8)};
  session.stored_frames = row.Unsigned(9);
  if (!row.IsNull(10)) session.last_durable_sequence = row.Unsigned(10);
  session.last_delta_version = row.Unsigned(11);
  return session;
}

}  // namespace

absl::StatusOr<SessionId> InsertSession(Connection& connection, const NewSession& session) {
  SEMMAP_RETURN_IF_ERROR(RequireMap(connection, session.map));
  SEMMAP_ASSIGN_OR_RETURN(const int64_t id, QueryInteger(connection, kTakeId, session.map));
  const Blob rig = EncodeRig(session.rig);
  Query insert(connection, kInsert);
  insert.Bind(session.map).Bind(id).BindText(session.name).BindText(session.vehicle_id);
  const absl::Status status = insert.Bind(session.started_at).BindBlob(rig).Run();
  if (IsConstraintViolation(status)) {
    return absl::AlreadyExistsError(absl::StrCat("session ", session.name, " exists"));
  }
  SEMMAP_RETURN_IF_ERROR(status);
  return SessionId(static_cast<uint64_t>(id));
}

absl::StatusOr<SessionInfo> ReadSession(Connection& connection, MapId map, SessionId session) {
  Query select(connection, kSelectById);
  select.Bind(map).Bind(session);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  return found ? ReadRow(select) : NoSuchSession(map, session);
}

absl::StatusOr<SessionInfo> ReadSession(Connection& connection, std::string_view name) {
  Query select(connection, kSelectByName);
  select.BindText(name);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return absl::NotFoundError(absl::StrCat("no session named ", std::string(name)));
  return ReadRow(select);
}

absl::StatusOr<std::vector<SessionInfo>> ReadSessions(Connection& connection, MapId map, SessionId after,
                                                      size_t limit) {
  SEMMAP_RETURN_IF_ERROR(RequireMap(connection, map));
  Query select(connection, kSelectPage);
  select.Bind(map).Bind(after).Bind(limit == 0 ? -1 : static_cast<int64_t>(limit));
  std::vector<SessionInfo> sessions;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) return sessions;
    SEMMAP_ASSIGN_OR_RETURN(sessions.emplace_back(), ReadRow(select));
  }
}

absl::Status UpdateCounters(Connection& connection, MapId map, SessionId session,
                            const SessionCounters& counters) {
  SEMMAP_RETURN_IF_ERROR(
      RunQuery(connection, kUpdateCounters, counters.frames_received, counters.frames_tracked, map, session));
  return connection.changes() == 1 ? absl::OkStatus() : NoSuchSession(map, session);
}

absl::Status CloseSession(Connection& connection, MapId map, SessionId session, TimestampNs ended_at) {
  SEMMAP_RETURN_IF_ERROR(ReadProgress(connection, map, session).status());
  return RunQuery(connection, kEnd, ended_at, map, session);
}

absl::StatusOr<SessionProgress> ReadProgress(Connection& connection, MapId map, SessionId session) {
  Query select(connection, kSelectProgress);
  select.Bind(map).Bind(session);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
  if (!found) return NoSuchSession(map, session);
  if (!select.IsNull(0)) {
    return absl::FailedPreconditionError(absl::StrCat("session ", session.value(), " has ended"));
  }
  SessionProgress progress{select.Unsigned(1), select.Unsigned(2), std::nullopt};
  if (!select.IsNull(3)) progress.last_durable_sequence = select.Unsigned(3);
  return progress;
}

absl::Status WriteProgress(Connection& connection, MapId map, SessionId session,
                           const SessionProgress& progress) {
  Query update(connection, kUpdateProgress);
  update.Bind(progress.delta_version)
      .Bind(progress.stored_frames)
      .BindOptional(progress.last_durable_sequence);
  return update.Bind(map).Bind(session).Run();
}

}  // namespace semmap::storage::sqlite
