#include "storage/sqlite/sqlite_map_store.h"

#include <array>
#include <fstream>
#include <utility>

#include <spdlog/spdlog.h>

#include "absl/base/thread_annotations.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "slam/common/mutex.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/backup.h"
#include "storage/sqlite/checkpointer.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/delta_writer.h"
#include "storage/sqlite/frame_rows.h"
#include "storage/sqlite/integrity_check.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/map_copy.h"
#include "storage/sqlite/map_file.h"
#include "storage/sqlite/map_outline_rows.h"
#include "storage/sqlite/map_part_rows.h"
#include "storage/sqlite/map_repair.h"
#include "storage/sqlite/map_rewrite.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/reader_pool.h"
#include "storage/sqlite/session_rows.h"
#include "storage/sqlite/store_lock.h"
#include "storage/sqlite/summary.h"
#include "storage/sqlite/transaction.h"
#include "storage/sqlite/whole_map.h"
#include "storage/sqlite/word_rows.h"
#include "storage/validation.h"

namespace semmap::storage::sqlite {
namespace {

class SqliteMapStore final : public MapStore {
 public:
  SqliteMapStore(std::unique_ptr<StoreLock> lock, std::unique_ptr<Connection> writer,
                 std::unique_ptr<Checkpointer> checkpointer, const ConnectionOptions& options,
                 const StorageConfig& config)
      : lock_(std::move(lock)),
        options_(options),
        max_keypoints_(static_cast<size_t>(config.keyframe_keypoints)),
        checkpointer_(std::move(checkpointer)),
        writer_(std::move(writer)),
        readers_(options, config.max_readers) {
    checkpointer_->Watch(*writer_);
  }

  // Ends the deletions that a crash cut short, unless another process has the store open: it could be in the
  // middle of a copy.
  absl::Status FinishDeletions() {
    if (!lock_->is_alone()) return absl::OkStatus();
    std::vector<MapId> hidden;
    SEMMAP_RETURN_IF_ERROR(Write([&](Connection& connection) -> absl::Status {
      SEMMAP_ASSIGN_OR_RETURN(hidden, HiddenMaps(connection));
      return absl::OkStatus();
    }));
    for (const MapId map : hidden) SEMMAP_RETURN_IF_ERROR(Purge(map));
    return absl::OkStatus();
  }

  absl::StatusOr<MapInfo> CreateMap(const NewMap& map) override {
    SEMMAP_RETURN_IF_ERROR(ValidateNewMap(map));
    return Write([&](Connection& connection) -> absl::StatusOr<MapInfo> {
      SEMMAP_ASSIGN_OR_RETURN(const MapId id, InsertMap(connection, map));
      return ReadMap(connection, id);
    });
  }

  absl::StatusOr<MapInfo> GetMap(std::string_view name) override {
    return Read([&](Connection& connection) { return ReadMap(connection, name); });
  }

  absl::StatusOr<MapInfo> GetMap(MapId map) override {
    return Read([&](Connection& connection) { return ReadMap(connection, map); });
  }

  absl::StatusOr<std::vector<MapInfo>> ListMaps(const MapListQuery& query) override {
    return Read([&](Connection& connection) { return ReadMaps(connection, query); });
  }

  absl::Status DeleteMap(MapId map) override {
    SEMMAP_RETURN_IF_ERROR(Write([&](Connection& connection) { return HideMap(connection, map); }));
    return Purge(map);
  }

  absl::StatusOr<MapInfo> RenameMap(MapId map, std::string_view name) override {
    SEMMAP_RETURN_IF_ERROR(ValidateMapName(name));
    return Write([&](Connection& connection) -> absl::StatusOr<MapInfo> {
      SEMMAP_RETURN_IF_ERROR(UpdateName(connection, map, name));
      return ReadMap(connection, map);
    });
  }

  absl::StatusOr<MapInfo> CopyMap(MapId map, std::string_view name, TimestampNs created_at,
                                  const ProgressVisitor& progress) override {
    SEMMAP_RETURN_IF_ERROR(ValidateMapName(name));
    return Copy(writer_.get(), MapCopy::From::kSameDatabase, map, name, created_at, progress);
  }

  absl::Status ExportMap(MapId map, const std::string& path, const ProgressVisitor& progress) override {
    SEMMAP_ASSIGN_OR_RETURN(const MapInfo info, GetMap(map));
    return WriteMapFile(options_, info, path, progress);
  }

  absl::StatusOr<MapInfo> ImportMap(const std::string& path, std::string_view name, TimestampNs created_at,
                                    const ProgressVisitor& progress) override {
    SEMMAP_RETURN_IF_ERROR(ValidateMapName(name));
    ConnectionOptions file = options_;
    file.path = path;
    SEMMAP_ASSIGN_OR_RETURN(const MapId map, CheckMapFile(file));
    // A connection of its own: the file stays attached between the steps, when others write.
    SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Connection> connection, Connection::Open(options_));
    SEMMAP_RETURN_IF_ERROR(AttachSource(*connection, path));
    return Copy(connection.get(), MapCopy::From::kAttached, map, name, created_at, progress);
  }

  absl::StatusOr<MapInfo> RewriteMap(const MapRewrite& rewrite, const ProgressVisitor& progress) override {
    SEMMAP_RETURN_IF_ERROR(ValidateDelta(rewrite.changes));
    SEMMAP_ASSIGN_OR_RETURN(RewriteSteps steps,
                            Write([&](Connection& writer) { return RewriteSteps::Begin(writer, rewrite); }));
    absl::Status status = RunSteps(writer_.get(), &steps, progress);
    if (status.ok()) status = Write([&](Connection& writer) { return steps.Finish(writer); });
    if (!status.ok()) {
      PurgeHidden(steps.result());
      return status;
    }
    PurgeHidden(rewrite.map.map);
    if (rewrite.joined && rewrite.delete_joined) PurgeHidden(rewrite.joined->map);
    return GetMap(steps.result());
  }

  absl::StatusOr<MapInfo> UpdateMap(MapId map, const MapChanges& changes) override {
    SEMMAP_RETURN_IF_ERROR(ValidateChanges(changes));
    return Write([&](Connection& connection) -> absl::StatusOr<MapInfo> {
      SEMMAP_RETURN_IF_ERROR(UpdateDescription(connection, map, changes));
      return ReadMap(connection, map);
    });
  }

  absl::StatusOr<SessionInfo> StartSession(const NewSession& session) override {
    SEMMAP_RETURN_IF_ERROR(ValidateNewSession(session));
    return Write([&](Connection& connection) -> absl::StatusOr<SessionInfo> {
      SEMMAP_ASSIGN_OR_RETURN(const SessionId id, InsertSession(connection, session));
      return ReadSession(connection, session.map, id);
    });
  }

  absl::Status UpdateSession(MapId map, SessionId session, const SessionCounters& counters) override {
    SEMMAP_RETURN_IF_ERROR(ValidateCounters(counters));
    return Write([&](Connection& connection) { return UpdateCounters(connection, map, session, counters); });
  }

  absl::Status EndSession(MapId map, SessionId session, TimestampNs ended_at,
                          const SessionCounters& counters) override {
    SEMMAP_RETURN_IF_ERROR(ValidateCounters(counters));
    return Write([&](Connection& connection) -> absl::Status {
      SEMMAP_RETURN_IF_ERROR(CloseSession(connection, map, session, ended_at));
      return UpdateCounters(connection, map, session, counters);
    });
  }

  absl::StatusOr<SessionInfo> GetSession(MapId map, SessionId session) override {
    return Read([&](Connection& connection) { return ReadSession(connection, map, session); });
  }

  absl::StatusOr<SessionInfo> GetSession(std::string_view name) override {
    return Read([&](Connection& connection) { return ReadSession(connection, name); });
  }

  absl::StatusOr<std::vector<SessionInfo>> ListSessions(MapId map, SessionId after, size_t limit) override {
    return Read([&](Connection& connection) { return ReadSessions(connection, map, after, limit); });
  }

  absl::Status Apply(MapId map, SessionId session, const MapDelta& delta) override {
    SEMMAP_RETURN_IF_ERROR(ValidateDelta(delta));
    return Write([&](Connection& connection) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_) {
      return WriteDelta(connection, map, session, delta, max_keypoints_, wording_ ? &*wording_ : nullptr);
    });
  }

  absl::Status ForEachMapPoint(MapId map, const MapPointQuery& query, const MapPointVisitor& visit) override {
    SEMMAP_RETURN_IF_ERROR(ValidateBox(query.box));
    return ReadOfMap(map, [&](Connection& connection) { return VisitPoints(connection, map, query, visit); });
  }

  absl::StatusOr<std::vector<MapPointRecord>> GetMapPoints(MapId map,
                                                           std::span<const MapPointId> ids) override {
    return ReadOfMap(map, [&](Connection& connection) { return ReadPoints(connection, map, ids); });
  }

  absl::Status ForEachKeyFrame(MapId map, const KeyFrameQuery& query, const KeyFrameVisitor& visit) override {
    SEMMAP_RETURN_IF_ERROR(ValidateBox(query.box));
    return ReadOfMap(map,
                     [&](Connection& connection) { return VisitKeyFrames(connection, map, query, visit); });
  }

  absl::StatusOr<KeyFrameEntry> GetKeyFrame(MapId map, KeyFrameId keyframe) override {
    return ReadOfMap(map, [&](Connection& connection) { return ReadKeyFrame(connection, map, keyframe); });
  }

  absl::StatusOr<KeyFrameObservations> GetObservations(MapId map, KeyFrameId keyframe) override {
    return ReadOfMap(map,
                     [&](Connection& connection) { return ReadObservations(connection, map, keyframe); });
  }

  absl::Status ForEachTrajectoryPose(MapId map, const TrajectoryQuery& query,
                                     const TrajectoryVisitor& visit) override {
    return ReadOfMap(map,
                     [&](Connection& connection) { return VisitTrajectory(connection, map, query, visit); });
  }

  absl::Status ReadWhole(MapId map, MapReader* reader) override {
    return ReadOfMap(map, [&](Connection& connection) { return ReadWholeMap(connection, map, reader); });
  }

  absl::Status ReadOutline(MapId map, uint64_t vocabulary, MapOutlineReader* reader) override {
    return ReadOfMap(
        map, [&](Connection& connection) { return ReadMapOutline(connection, map, vocabulary, reader); });
  }

  absl::Status ReadParts(MapId map, absl::FunctionRef<absl::Status(MapPartReader&)> read) override {
    return ReadOfMap(map, [&](Connection& connection) { return ReadMapParts(connection, map, read); });
  }

  void StoreWordsBy(PlaceWording wording) override {
    MutexLock lock(&writer_mutex_);
    wording_ = std::move(wording);
  }

  absl::Status StoreWords(MapId map, uint64_t version, uint64_t vocabulary,
                          std::span<const KeyFrameWords> keyframes) override {
    return Write([&](Connection& connection) -> absl::Status {
      SEMMAP_ASSIGN_OR_RETURN(const MapInfo info, ReadMap(connection, map));
      if (info.version != version) return absl::AbortedError("the map has changed");
      ByteWriter buffer;
      for (const KeyFrameWords& words : keyframes)
        SEMMAP_RETURN_IF_ERROR(WriteWords(connection, map, vocabulary, words, &buffer));
      return absl::OkStatus();
    });
  }

  absl::StatusOr<MapSummary> Summarize(MapId map) override {
    return Read([&](Connection& connection) { return SummarizeMap(connection, map); });
  }

  absl::StatusOr<std::vector<IntegrityFinding>> CheckIntegrity(MapId map, size_t max_findings) override {
    return Read([&](Connection& connection) { return CheckMapIntegrity(connection, map, max_findings); });
  }

  absl::Status RepairMap(MapId map) override {
    return Write([&](Connection& connection) { return RepairMapRows(connection, map); });
  }

  absl::Status Backup(const std::string& path, const ProgressVisitor& progress) override {
    return Read([&](Connection& connection) { return BackupDatabase(connection, path, progress); });
  }

  absl::StatusOr<uint64_t> DatabaseBytes() override {
    return Read([](Connection& connection) { return sqlite::DatabaseBytes(connection); });
  }

 private:
  static const absl::Status& StatusOf(const absl::Status& status) { return status; }
  template <typename T>
  static const absl::Status& StatusOf(const absl::StatusOr<T>& result) {
    return result.status();
  }

  // Runs work(connection), which answers a Status or StatusOr, as one transaction: committed when it
  // succeeds.
  template <typename Work>
  auto Write(Work&& work) -> decltype(work(std::declval<Connection&>())) {
    return WriteBy(writer_.get(), std::forward<Work>(work));
  }

  // The same on another connection to the database.
  template <typename Work>
  auto WriteBy(Connection* connection, Work&& work) -> decltype(work(*connection)) {
    MutexLock lock(&writer_mutex_);
    SEMMAP_ASSIGN_OR_RETURN(Transaction transaction,
                            Transaction::Begin(*connection, Transaction::Kind::kWrite));
    auto result = work(*connection);
    SEMMAP_RETURN_IF_ERROR(StatusOf(result));
    SEMMAP_RETURN_IF_ERROR(transaction.Commit());
    return result;
  }

  // Runs work(connection) on a snapshot.
  template <typename Work>
  auto Read(Work&& work) -> decltype(work(std::declval<Connection&>())) {
    SEMMAP_ASSIGN_OR_RETURN(ReaderPool::Lease lease, readers_.Read());
    return work(lease.connection());
  }

  template <typename Work>
  auto ReadOfMap(MapId map, Work&& work) -> decltype(work(std::declval<Connection&>())) {
    return Read([&](Connection& connection) -> decltype(work(connection)) {
      SEMMAP_RETURN_IF_ERROR(RequireMap(connection, map));
      return work(connection);
    });
  }

  absl::StatusOr<MapInfo> Copy(Connection* connection, MapCopy::From from, MapId map, std::string_view name,
                               TimestampNs created_at, const ProgressVisitor& progress) {
    SEMMAP_ASSIGN_OR_RETURN(MapCopy copy, WriteBy(connection, [&](Connection& writer) {
                              return MapCopy::Begin(writer, from, map, created_at);
                            }));
    absl::Status status = RunSteps(connection, &copy, progress);
    if (status.ok()) {
      status = WriteBy(connection, [&](Connection& writer) { return copy.Finish(writer, name); });
    }
    if (status.ok()) return GetMap(copy.copy());
    PurgeHidden(copy.copy());
    return status;
  }

  template <typename Steps>
  absl::Status RunSteps(Connection* connection, Steps* steps, const ProgressVisitor& progress) {
    bool done = false;
    while (!done) {
      SEMMAP_ASSIGN_OR_RETURN(done,
                              WriteBy(connection, [&](Connection& writer) { return steps->Step(writer); }));
      if (progress && !progress(steps->Progress())) return absl::CancelledError("the copy was cancelled");
    }
    return absl::OkStatus();
  }

  // Of a hidden map: what is left of it when this fails goes at the next start.
  void PurgeHidden(MapId map) {
    if (const absl::Status purged = Purge(map); !purged.ok()) {
      spdlog::warn("storage: a hidden map stays until the next start: {}", purged.ToString());
    }
  }

  absl::Status Purge(MapId map) {
    bool done = false;
    while (!done) {
      SEMMAP_RETURN_IF_ERROR(Write([&](Connection& connection) -> absl::Status {
        SEMMAP_ASSIGN_OR_RETURN(done, PurgeStep(connection, map));
        return absl::OkStatus();
      }));
    }
    return absl::OkStatus();
  }

  const std::unique_ptr<StoreLock> lock_;
  const ConnectionOptions options_;
  const size_t max_keypoints_;
  const std::unique_ptr<Checkpointer> checkpointer_;
  Mutex writer_mutex_;
  const std::unique_ptr<Connection> writer_ ABSL_PT_GUARDED_BY(writer_mutex_);
  std::optional<PlaceWording> wording_ ABSL_GUARDED_BY(writer_mutex_);
  ReaderPool readers_;
};

absl::StatusOr<std::string> PathOf(const std::string& uri) {
  absl::string_view path = uri;
  if (!absl::ConsumePrefix(&path, "sqlite:"))
    return absl::InvalidArgumentError(absl::StrCat("no sqlite uri: ", uri));
  absl::ConsumePrefix(&path, "//");
  // SQLite gives a meaning of its own to ":memory:" and "file:".
  if (path.empty() || path.front() == ':' || absl::StartsWith(path, "file:") ||
      absl::StrContains(path, '\0')) {
    return absl::InvalidArgumentError(absl::StrCat("no path of a file in uri ", uri));
  }
  return std::string(path);
}

// Tells a file of another kind from a damaged database before SQLite writes a byte to it.
absl::Status CheckHeader(const std::string& path) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::ifstream file(path, std::ios::binary);
  std::array<char, kMagic.size()> header{};
  if (!file.is_open() || !file.read(header.data(), 1))
    return absl::OkStatus();  // new, or for SQLite to complain of
  file.read(header.data() + 1, header.size() - 1);
  if (std::string_view(header.data(), header.size()) == kMagic) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(path, " is no database"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<MapStore>> OpenSqliteMapStore(const StorageConfig& config) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string path, PathOf(config.uri));
  SEMMAP_RETURN_IF_ERROR(CheckHeader(path));
  ConnectionOptions options;
  options.path = path;
  options.full_synchronous = config.synchronous == "full";
  options.busy_timeout_ms = config.busy_timeout_ms;
  options.cache_mb = config.cache_mb;
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<Connection> writer, Connection::Open(options));
  auto lock = std::make_unique<StoreLock>(path);
  SEMMAP_RETURN_IF_ERROR(MigrateDatabase(*writer, EmbeddedMigrations()));
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<Checkpointer> checkpointer, Checkpointer::Start(options));
  const StoreLock& opened = *lock;
  auto store = std::make_unique<SqliteMapStore>(std::move(lock), std::move(writer), std::move(checkpointer),
                                                options, config);
  SEMMAP_RETURN_IF_ERROR(store->FinishDeletions());
  opened.Share();
  return store;
}

}  // namespace semmap::storage::sqlite
