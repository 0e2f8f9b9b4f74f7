#include "storage/sqlite/map_file.h"

#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "slam/common/status_macros.h"
#include "storage/cell_grid.h"
#include "storage/sqlite/integrity_check.h"
#include "storage/sqlite/map_copy.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/partial_file.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/transaction.h"
#include "storage/sqlite/whole_map.h"
#include "storage/validation.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kAttach[] = "ATTACH ? AS source";
constexpr char kSelectApplicationId[] = "PRAGMA application_id";
constexpr char kSelectVersion[] = "PRAGMA user_version";
constexpr char kSelectSchema[] =
    "SELECT type || ' ' || name || ' ' || tbl_name || ' ' || coalesce(sql, '') FROM sqlite_schema ORDER BY 1";
constexpr char kHasPoints[] = "SELECT EXISTS (SELECT 1 FROM points)";
constexpr char kSelectMaps[] = "SELECT map_id FROM maps LIMIT 2";
constexpr std::string_view kMagic("SQLite format 3\0", 16);

absl::Status Refuse(absl::string_view what) { return absl::InvalidArgumentError(what); }

absl::Status CheckMagic(const std::string& path) {
  std::string header(kMagic.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  const bool read = static_cast<bool>(file.read(header.data(), static_cast<std::streamsize>(header.size())));
  return read && header == kMagic ? absl::OkStatus() : Refuse("it is no map file");
}

absl::StatusOr<std::vector<std::string>> SchemaOf(Connection& connection) {
  Query select(connection, kSelectSchema);
  std::vector<std::string> schema;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) return schema;
    schema.push_back(select.Text(0));
  }
}

// Views, triggers and generated columns can make a look at a table endless: only what we ourselves make is
// ever looked at.
absl::Status CheckSchema(Connection& connection) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t application, QueryInteger(connection, kSelectApplicationId));
  SEMMAP_ASSIGN_OR_RETURN(const int64_t version, QueryInteger(connection, kSelectVersion));
  const auto migrations = EmbeddedMigrations();
  if (application != kApplicationId || version < 1) return Refuse("it is no map file");
  if (version > static_cast<int64_t>(migrations.size())) return Refuse("it was written by a newer version");
  ConnectionOptions in_memory;
  in_memory.path = ":memory:";
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Connection> fresh, Connection::Open(in_memory));
  SEMMAP_RETURN_IF_ERROR(MigrateDatabase(*fresh, migrations.first(static_cast<size_t>(version))));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> expected, SchemaOf(*fresh));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> found, SchemaOf(connection));
  return found == expected ? absl::OkStatus() : Refuse("its tables are not those of a map file");
}

// As ChooseCellSize may have chosen it with the first points.
absl::Status CheckCellSize(Connection& connection, MapId map) {
  SEMMAP_ASSIGN_OR_RETURN(const MapPlacement placement, ReadPlacement(connection, map));
  if (IsCellSize(placement.cell_size)) return absl::OkStatus();
  SEMMAP_ASSIGN_OR_RETURN(const int64_t has_points, QueryInteger(connection, kHasPoints));
  const bool none_yet = placement.cell_size == 0 && has_points == 0;
  return none_yet ? absl::OkStatus() : Refuse("its cells have no size that cells have");
}

absl::StatusOr<MapId> OnlyMap(Connection& connection) {
  Query select(connection, kSelectMaps);
  SEMMAP_ASSIGN_OR_RETURN(const bool first, select.Step());
  if (!first) return Refuse("it holds no map");
  const auto map = select.IdAt<MapId>(0);
  SEMMAP_ASSIGN_OR_RETURN(const bool second, select.Step());
  if (second) return Refuse("it holds more than one map");
  return map;
}

// Refuses what no session could have stored.
class ContentValidation : public MapReader {
 public:
  absl::Status OnMap(const MapInfo& map) override {
    return ValidateNewMap(
        {map.name, map.created_at, map.rig, map.scale_known, map.display_name, map.labels, map.anchor});
  }
  absl::Status OnSession(const SessionInfo& session) override {
    SEMMAP_RETURN_IF_ERROR(ValidateCounters(session.counters));
    if (!IsUtf8(session.vehicle_id)) return Refuse("a vehicle's name is not UTF-8");
    return ValidateNewSession(
        {session.map, session.name, session.vehicle_id, session.started_at, session.rig});
  }
  absl::Status OnPoint(const MapPointRecord& point) override {
    MapDelta delta;
    delta.upserted_points.push_back(point);
    return ValidateDelta(delta);
  }
  absl::Status OnKeyFrame(const KeyFrameEntry& keyframe, KeyFrameObservations observations) override {
    MapDelta delta;
    delta.added_keyframes.push_back(keyframe.record);
    delta.observations.push_back(std::move(observations));
    return ValidateDelta(delta);
  }
};

absl::StatusOr<MapId> CheckContents(const ConnectionOptions& file) {
  SEMMAP_RETURN_IF_ERROR(CheckMagic(file.path));
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Connection> connection, Connection::Open(file));
  SEMMAP_RETURN_IF_ERROR(CheckSchema(*connection));
  SEMMAP_RETURN_IF_ERROR(MigrateDatabase(*connection, EmbeddedMigrations()));
  SEMMAP_ASSIGN_OR_RETURN(const MapId map, OnlyMap(*connection));
  SEMMAP_RETURN_IF_ERROR(CheckCellSize(*connection, map));
  SEMMAP_ASSIGN_OR_RETURN(const auto findings, CheckMapIntegrity(*connection, map, 1));
  if (!findings.empty()) return Refuse(absl::StrCat(findings[0].kind, ": ", findings[0].message));
  ContentValidation validation;
  SEMMAP_RETURN_IF_ERROR(ReadWholeMap(*connection, map, &validation));
  return map;
}

// Whatever is wrong with the file is the fault of who sent it, who need not know where it lies.
absl::Status AsFaultOfFile(const absl::Status& status, const std::string& path) {
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kResourceExhausted:
      return status;
    default:
      return Refuse(absl::StrCat("the file is not a sound map: ",
                                 absl::StrReplaceAll(status.message(), {{path, "it"}})));
  }
}

absl::Status CopyInto(Connection& target, const MapInfo& map, const ProgressVisitor& progress) {
  // A deferred transaction: it takes the write lock of the new file alone, and sees the source as it is at
  // its first look.
  SEMMAP_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(target, Transaction::Kind::kRead));
  SEMMAP_ASSIGN_OR_RETURN(MapCopy copy,
                          MapCopy::Begin(target, MapCopy::From::kAttached, map.id, map.created_at));
  for (bool done = false; !done;) {
    SEMMAP_ASSIGN_OR_RETURN(done, copy.Step(target));
    if (progress && !progress(copy.Progress())) return absl::CancelledError("the export was cancelled");
  }
  SEMMAP_RETURN_IF_ERROR(copy.Finish(target, map.name));
  return transaction.Commit();
}

}  // namespace

absl::Status AttachSource(Connection& connection, const std::string& path) {
  Query attach(connection, kAttach);
  return attach.BindText(path).Run();
}

absl::Status WriteMapFile(const ConnectionOptions& source, const MapInfo& map, const std::string& path,
                          const ProgressVisitor& progress) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) return absl::AlreadyExistsError(absl::StrCat(path, " exists"));
  const PartialFile partial(path);
  {
    ConnectionOptions options;
    options.path = partial.path();
    options.cache_mb = source.cache_mb;
    SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Connection> target, Connection::Open(options));
    SEMMAP_RETURN_IF_ERROR(MigrateDatabase(*target, EmbeddedMigrations()));
    // A file that is not whole is of no use: no log, no waiting for the disk.
    SEMMAP_RETURN_IF_ERROR(target->Execute("PRAGMA journal_mode=MEMORY; PRAGMA synchronous=OFF"));
    SEMMAP_RETURN_IF_ERROR(AttachSource(*target, source.path));
    SEMMAP_RETURN_IF_ERROR(CopyInto(*target, map, progress));
  }
  return partial.Finish();
}

absl::StatusOr<MapId> CheckMapFile(const ConnectionOptions& file) {
  auto map = CheckContents(file);
  if (map.ok()) return map;
  return AsFaultOfFile(map.status(), file.path);
}

}  // namespace semmap::storage::sqlite
