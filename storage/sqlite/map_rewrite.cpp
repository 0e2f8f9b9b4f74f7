#include "storage/sqlite/map_rewrite.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/delta_writer.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/query.h"

namespace semmap::storage::sqlite {
namespace {

// Of a step: small enough that a vehicle's delta does not wait long for the lock.
constexpr size_t kKeyFramesPerStep = 100;
constexpr size_t kPointsPerStep = 5000;

constexpr char kSelectVersion[] = "SELECT version FROM maps WHERE map_id = ? AND name IS NOT NULL";
constexpr char kSelectGreatest[] =
    "SELECT last_keyframe_id, last_point_id, last_session_id FROM maps WHERE map_id = ?";
constexpr char kSelectDepth[] =
    "SELECT (SELECT scale_known FROM maps WHERE map_id = ?1), (SELECT scale_known FROM maps WHERE map_id = "
    "?2)";
// ?1 is the result, ?2 the map.
constexpr char kCount[] =
    "UPDATE maps SET (keyframe_count, point_count, last_keyframe_id, last_point_id, last_session_id) = "
    "(SELECT keyframe_count, point_count, last_keyframe_id, last_point_id, last_session_id FROM maps "
    "WHERE map_id = ?2) WHERE map_id = ?1";
constexpr char kAddCount[] =
    "UPDATE maps SET (keyframe_count, point_count, last_keyframe_id, last_point_id, last_session_id) = "
    "(SELECT maps.keyframe_count + joined.keyframe_count, maps.point_count + joined.point_count, "
    "maps.last_keyframe_id + joined.last_keyframe_id, maps.last_point_id + joined.last_point_id, "
    "maps.last_session_id + joined.last_session_id FROM maps AS joined WHERE joined.map_id = ?2) "
    "WHERE map_id = ?1";
constexpr char kCountMisplaced[] = "SELECT count(*) FROM points WHERE map_id = ? AND cell_key = -1";
constexpr char kIsWhole[] =
    "SELECT keyframe_count = (SELECT count(*) FROM keyframes WHERE map_id = ?1) AND "
    "point_count = (SELECT count(*) FROM points WHERE point_key > ?1 << 40 AND point_key < (?1 + 1) << 40) "
    "AND "
    "(SELECT coalesce(sum(stored_frames), 0) FROM sessions WHERE map_id = ?1) = "
    "(SELECT count(*) FROM frames WHERE map_id = ?1) FROM maps WHERE map_id = ?1";
// What people may have changed since the copy began.
constexpr char kTakePlace[] =
    "UPDATE maps SET (name, created_at, display_name, labels, latitude_deg, longitude_deg, altitude_m, "
    "enu_from_map, anchor_source, anchor_rms_m, version, revision) = (SELECT ?3, created_at, display_name, "
    "labels, latitude_deg, longitude_deg, altitude_m, enu_from_map, anchor_source, anchor_rms_m, version + "
    "1, "
    "revision FROM maps AS former WHERE former.map_id = ?2), updated_at = unixepoch() * 1000000000 "
    "WHERE map_id = ?1";
constexpr char kSelectName[] = "SELECT name FROM maps WHERE map_id = ?";
constexpr char kSelectSessionNames[] =
    "SELECT session_id, name FROM sessions WHERE map_id = ? AND name IS NOT NULL";
constexpr char kNameSession[] =
    "UPDATE sessions SET name = (SELECT CASE WHEN EXISTS (SELECT 1 FROM sessions AS other WHERE other.name = "
    "?3) THEN ?3 || '-' || ?1 ELSE ?3 END) WHERE map_id = ?1 AND session_id = ?2";

absl::Status RequireVersion(Connection& connection, const MapRewrite::Basis& basis) {
  Query select(connection, kSelectVersion);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Bind(basis.map).Step());
  if (found && select.Unsigned(0) == basis.version) return absl::OkStatus();
  return absl::AbortedError(absl::StrCat("map ", basis.map.value(), " was changed meanwhile"));
}

absl::Status RequireVersions(Connection& connection, const MapRewrite& rewrite) {
  SEMMAP_RETURN_IF_ERROR(RequireVersion(connection, rewrite.map));
  return rewrite.joined ? RequireVersion(connection, *rewrite.joined) : absl::OkStatus();
}

absl::StatusOr<JoinedIds> GreatestIds(Connection& connection, MapId map) {
  Query select(connection, kSelectGreatest);
  SEMMAP_RETURN_IF_ERROR(select.Bind(map).Step().status());
  return JoinedIds{select.Unsigned(0), select.Unsigned(1), select.Unsigned(2)};
}

// A map whose unit is arbitrary was made with one eye, and metres mean nothing in it.
absl::StatusOr<bool> MustForgetDepth(Connection& connection, MapId map, MapId joined) {
  Query select(connection, kSelectDepth);
  SEMMAP_RETURN_IF_ERROR(select.Bind(map).Bind(joined).Step().status());
  return select.Int(0) == 0 && select.Int(1) != 0;
}

// Once more before it is shown: whoever opens the store where it cannot be locked purges hidden maps.
absl::Status RequireWhole(Connection& connection, MapId hidden) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t whole, QueryInteger(connection, kIsWhole, hidden));
  return whole != 0
             ? absl::OkStatus()
             : absl::AbortedError(
                   "what was made is not whole: another process purged some of it, or the map was not sound");
}

struct NamedSession {
  SessionId id;
  std::string name;
};

absl::StatusOr<std::vector<NamedSession>> SessionNames(Connection& connection, MapId map) {
  Query select(connection, kSelectSessionNames);
  select.Bind(map);
  std::vector<NamedSession> sessions;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) return sessions;
    sessions.push_back({select.IdAt<SessionId>(0), select.Text(1)});
  }
}

// Gives sessions of `map` these names, or, where they are taken, names with the map's id behind.
absl::Status NameSessions(Connection& connection, MapId map, const std::vector<NamedSession>& sessions,
                          uint64_t offset) {
  for (const NamedSession& session : sessions) {
    Query update(connection, kNameSession);
    update.Bind(map).Bind(session.id.value() + offset).BindText(session.name);
    SEMMAP_RETURN_IF_ERROR(update.Run());
  }
  return absl::OkStatus();
}

// --- Parts of the changes

// Moves the part of `from` that lies in [begin, end) of all changes to `to`; `passed` counts those before.
template <typename Item>
void TakePart(const std::vector<Item>& from, size_t begin, size_t end, size_t* passed,
              std::vector<Item>* to) {
  const size_t first = std::clamp(begin, *passed, *passed + from.size()) - *passed;
  const size_t last = std::clamp(end, *passed, *passed + from.size()) - *passed;
  to->assign(from.begin() + static_cast<std::ptrdiff_t>(first),
             from.begin() + static_cast<std::ptrdiff_t>(last));
  *passed += from.size();
}

MapDelta PartOf(const MapDelta& changes, size_t begin, size_t end) {
  MapDelta part;
  size_t passed = 0;
  TakePart(changes.moved_keyframes, begin, end, &passed, &part.moved_keyframes);
  TakePart(changes.upserted_points, begin, end, &passed, &part.upserted_points);
  TakePart(changes.observations, begin, end, &passed, &part.observations);
  TakePart(changes.removed_keyframes, begin, end, &passed, &part.removed_keyframes);
  TakePart(changes.removed_points, begin, end, &passed, &part.removed_points);
  return part;
}

// Where the step that begins at `begin` ends: points are written faster than keyframes.
size_t EndOfStep(const MapDelta& changes, size_t begin) {
  const size_t points_begin = changes.moved_keyframes.size();
  const size_t points_end = points_begin + changes.upserted_points.size();
  const size_t others_end = points_end + changes.observations.size() + changes.removed_keyframes.size();
  if (begin < points_begin) return std::min(begin + kKeyFramesPerStep, points_begin);
  if (begin < points_end) return std::min(begin + kPointsPerStep, points_end);
  if (begin < others_end) return std::min(begin + kKeyFramesPerStep, others_end);
  return begin + kPointsPerStep;
}

}  // namespace

absl::StatusOr<RewriteSteps> RewriteSteps::Begin(Connection& connection, const MapRewrite& rewrite) {
  const MapDelta& changes = rewrite.changes;
  if (changes.reset || !changes.added_keyframes.empty() || !changes.frames.empty())
    return absl::InvalidArgumentError("the changes of a map add keyframes or frames to it");
  SEMMAP_RETURN_IF_ERROR(RequireVersions(connection, rewrite));
  SEMMAP_ASSIGN_OR_RETURN(MapCopy copy,
                          MapCopy::Begin(connection, MapCopy::From::kSameDatabase, rewrite.map.map, 0));
  RewriteSteps steps(&rewrite, std::move(copy));
  if (rewrite.joined) {
    SEMMAP_ASSIGN_OR_RETURN(const JoinedIds ids, GreatestIds(connection, rewrite.map.map));
    SEMMAP_ASSIGN_OR_RETURN(const bool forget_depth,
                            MustForgetDepth(connection, rewrite.map.map, rewrite.joined->map));
    steps.join_.emplace(rewrite.joined->map, steps.result(), ids, forget_depth);
  }
  return steps;
}

absl::Status RewriteSteps::Count(Connection& connection) const {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kCount, result(), rewrite_->map.map));
  return rewrite_->joined ? RunQuery(connection, kAddCount, result(), rewrite_->joined->map)
                          : absl::OkStatus();
}

size_t RewriteSteps::ChangeCount() const {
  const MapDelta& changes = rewrite_->changes;
  return changes.moved_keyframes.size() + changes.upserted_points.size() + changes.observations.size() +
         changes.removed_keyframes.size() + changes.removed_points.size();
}

absl::StatusOr<bool> RewriteSteps::ChangeNext(Connection& connection) {
  if (changed_ >= ChangeCount()) return true;
  const size_t end = EndOfStep(rewrite_->changes, changed_);
  SEMMAP_RETURN_IF_ERROR(WriteChanges(connection, result(), PartOf(rewrite_->changes, changed_, end)));
  changed_ = end;
  return false;
}

absl::StatusOr<bool> RewriteSteps::StepOf(Stage stage, Connection& connection) {
  switch (stage) {
    case Stage::kCopy:
      return copy_.Step(connection);
    case Stage::kJoin:
      return join_ ? join_->Step(connection) : absl::StatusOr<bool>(true);
    case Stage::kCount:
      SEMMAP_RETURN_IF_ERROR(Count(connection));
      return true;
    case Stage::kChange:
      return ChangeNext(connection);
    case Stage::kDone:
      return true;
  }
  return true;
}

absl::StatusOr<bool> RewriteSteps::Step(Connection& connection) {
  // Parts of different versions need not fit together.
  SEMMAP_RETURN_IF_ERROR(RequireVersions(connection, *rewrite_));
  SEMMAP_ASSIGN_OR_RETURN(const bool done, StepOf(stage_, connection));
  if (done && stage_ != Stage::kDone) stage_ = static_cast<Stage>(static_cast<int>(stage_) + 1);
  return stage_ == Stage::kDone;
}

double RewriteSteps::Progress() const {
  constexpr double kCopyShare = 0.4;
  if (stage_ == Stage::kCopy) return kCopyShare * copy_.Progress();
  const double changed = static_cast<double>(changed_) / static_cast<double>(ChangeCount() + 1);
  return kCopyShare + (1 - kCopyShare) * std::min(changed, 1.0);
}

absl::Status RewriteSteps::Finish(Connection& connection) {
  SEMMAP_RETURN_IF_ERROR(RequireVersions(connection, *rewrite_));
  SEMMAP_ASSIGN_OR_RETURN(const int64_t misplaced, QueryInteger(connection, kCountMisplaced, result()));
  if (misplaced > 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("the changes leave ", misplaced, " points of the joined map where they were"));
  }
  SEMMAP_RETURN_IF_ERROR(RequireWhole(connection, result()));
  std::string name;
  {
    Query select(connection, kSelectName);
    SEMMAP_RETURN_IF_ERROR(select.Bind(rewrite_->map.map).Step().status());
    name = select.Text(0);
  }
  SEMMAP_ASSIGN_OR_RETURN(const auto sessions, SessionNames(connection, rewrite_->map.map));
  SEMMAP_RETURN_IF_ERROR(HideMap(connection, rewrite_->map.map));
  {
    Query show(connection, kTakePlace);
    SEMMAP_RETURN_IF_ERROR(show.Bind(result()).Bind(rewrite_->map.map).BindText(name).Run());
  }
  SEMMAP_RETURN_IF_ERROR(NameSessions(connection, result(), sessions, 0));
  SEMMAP_ASSIGN_OR_RETURN(const MapInfo shown, ReadMap(connection, result()));
  if (!shown.anchor && rewrite_->anchor)
    SEMMAP_RETURN_IF_ERROR(UpdateDescription(connection, result(), {.anchor = rewrite_->anchor}));
  if (!rewrite_->joined) return absl::OkStatus();
  const MapId joined = rewrite_->joined->map;
  SEMMAP_ASSIGN_OR_RETURN(const auto joined_sessions, SessionNames(connection, joined));
  SEMMAP_ASSIGN_OR_RETURN(const JoinedIds ids, GreatestIds(connection, rewrite_->map.map));
  if (rewrite_->delete_joined) SEMMAP_RETURN_IF_ERROR(HideMap(connection, joined));
  return NameSessions(connection, result(), joined_sessions, ids.sessions);
}

}  // namespace semmap::storage::sqlite
