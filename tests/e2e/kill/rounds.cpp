#include "rounds.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "connect.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/migrations.h"
#include "version_one.h"

namespace semmap::kill_test {
namespace {

namespace fs = std::filesystem;

constexpr char kBase[] = "base";
// Copies of the base beside it in the old database, so that migrating it takes a while.
constexpr int kOldCopies = 4;
// Work goes slower beside a drive than when it was measured.
constexpr double kSlower = 1.5;

absl::Status MakeDirectory(const std::string& path) {
  std::error_code error;
  fs::remove_all(path, error);
  fs::create_directories(path, error);
  return error ? absl::InternalError(absl::StrCat(path, ": ", error.message())) : absl::OkStatus();
}

absl::StatusOr<std::string> Export(client::Client& client, const std::string& map) {
  v1::ExportMapRequest request;
  request.set_name(map);
  request.set_format(v1::MAP_FILE_FORMAT_SEMMAP);
  SEMMAP_ASSIGN_OR_RETURN(const client::Client::Export made, client.ExportMap(request, nullptr));
  std::string bytes;
  SEMMAP_RETURN_IF_ERROR(
      client.ReadArtifact(made.file.artifact(), 0, [&](const v1::ReadArtifactResponse& response) {
        bytes += response.chunk();
        return true;
      }));
  return bytes;
}

// Waits until the log says so; false when it does not for long. The log is another process's: it is asked
// again and again.
bool WaitForLog(const std::string& path, const std::string& text) {
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (absl::Now() < deadline) {
    std::ifstream file(path);
    const std::string log((std::istreambuf_iterator<char>(file)), {});
    if (log.find(text) != std::string::npos) return true;
    absl::SleepFor(absl::Microseconds(500));
  }
  return false;
}

constexpr char kMigrationBegins[] = "running migration";

}  // namespace

const char* NameOf(Phase phase) {
  static constexpr std::array kNames = {"drive",  "extend", "loop",   "copy",
                                        "import", "merge",  "backup", "migration"};
  return kNames[static_cast<size_t>(phase)];
}

Rounds::Rounds(RoundsOptions options, const Recording& street, const Recording& round)
    : options_(std::move(options)), street_(street), round_(round), random_(options_.seed) {}

Rounds::~Rounds() = default;

Rounds::Moment Rounds::DrawMoment(const Recording& recording, double from, double until) {
  const double frame = (from + (until - from) * Draw()) * static_cast<double>(recording.frames.size());
  return {static_cast<size_t>(frame), (frame - std::floor(frame)) * frame_time_};
}

absl::Status Rounds::Start(const std::string& data) {
  server_ = std::make_unique<ServerProcess>(options_.config, data);
  if (server_->address().empty())
    return absl::InternalError(absl::StrCat("semmapd does not start; see ", data, "/semmapd.log"));
  return absl::OkStatus();
}

// --- What the kills need

absl::StatusOr<Testimony> Rounds::DriveUndisturbed(const Recording& recording, const std::string& map) {
  Testimony told = Vehicle(recording, server_->address(), map, v1::SESSION_MODE_MAP).Finish();
  SEMMAP_RETURN_IF_ERROR(told.end);
  return told;
}

absl::Status Rounds::Prepare() {
  const std::string data = options_.directory + "/first";
  SEMMAP_RETURN_IF_ERROR(MakeDirectory(data));
  SEMMAP_RETURN_IF_ERROR(Start(data));
  SEMMAP_ASSIGN_OR_RETURN(base_, DriveUndisturbed(street_, kBase));
  frame_time_ = (base_.answers.back() - base_.answers.front()) / static_cast<double>(base_.answers.size());
  SEMMAP_RETURN_IF_ERROR(MeasureLoop());
  SEMMAP_ASSIGN_OR_RETURN(const auto connection, Connect(server_->address()));
  client::Client client(connection);
  SEMMAP_ASSIGN_OR_RETURN(base_file_, Export(client, kBase));
  for (int i = 0; i < kOldCopies; ++i)
    SEMMAP_RETURN_IF_ERROR(client.CopyMap(kBase, absl::StrCat(kBase, i), nullptr).status());
  server_->Stop(SIGTERM);
  return MakeOldDatabase();
}

absl::Status Rounds::MeasureLoop() {
  SEMMAP_ASSIGN_OR_RETURN(const Testimony told, DriveUndisturbed(round_, "round"));
  if (!told.corrected) return absl::InternalError("the drive with a loop has no loop");
  const auto after = std::upper_bound(told.answers.begin(), told.answers.end(), *told.corrected);
  const auto answers = static_cast<size_t>(after - told.answers.begin());
  // The vehicle is told when the map moves, before that is stored and before all is adjusted, which is over
  // when frames are answered again.
  loop_begins_ = {std::max<size_t>(answers, 2) - 1, absl::ZeroDuration()};
  const size_t ends = std::min(answers + 1, told.answers.size() - 1);
  loop_time_ = told.answers[ends] - told.answers[loop_begins_.answers - 1];
  return absl::OkStatus();
}

absl::Status Rounds::MakeOldDatabase() {
  const std::string data = options_.directory + "/old";
  SEMMAP_RETURN_IF_ERROR(MakeDirectory(data));
  SEMMAP_RETURN_IF_ERROR(
      WriteVersionOne(options_.directory + "/first/semmap.db", options_.directory + "/version1.db"));
  fs::copy_file(options_.directory + "/version1.db", data + "/semmap.db");
  DaemonProcess process(ServerProcess::Arguments(options_.config, data), data + "/semmapd.log");
  if (!WaitForLog(data + "/semmapd.log", kMigrationBegins)) return absl::InternalError("nothing is migrated");
  const absl::Time begin = absl::Now();
  if (!WaitForLog(data + "/semmapd.log", storage::sqlite::EmbeddedMigrations().back().name))
    return absl::InternalError("the last migration does not run");
  // Half of the kills come before the last migration, the others in it, at the commit, or soon after.
  migration_time_ = 2 * (absl::Now() - begin);
  if (process.ReadLine().empty()) return absl::InternalError("the old database does not open");
  return absl::OkStatus();
}

absl::Status Rounds::BeginStore() {
  data_ = absl::StrCat(options_.directory, "/store");
  SEMMAP_RETURN_IF_ERROR(MakeDirectory(data_));
  SEMMAP_RETURN_IF_ERROR(Restart());
  SEMMAP_ASSIGN_OR_RETURN(const auto connection, Connect(server_->address()));
  client::Client client(connection);
  testimonies_.clear();
  last_drive_.reset();
  return ImportWork(base_, base_file_)->Run(client, kBase);
}

// --- Kills

void Rounds::KillDrive(const Recording& recording, const std::string& map, v1::SessionMode mode,
                       const Moment& moment, Tally* tally) {
  Vehicle vehicle(recording, server_->address(), map, mode);
  vehicle.WaitForAnswers(moment.answers);
  absl::SleepFor(moment.later);
  server_->Stop(SIGKILL);
  Testimony told = vehicle.Finish();
  if (!told.end.ok()) ++tally->inside;
  testimonies_.push_back(std::move(told));
}

absl::Status Rounds::KillDuringDrive(Tally* tally) {
  KillDrive(street_, absl::StrCat("drive-", kills_), v1::SESSION_MODE_MAP, DrawMoment(street_, 0, 1), tally);
  const size_t index = testimonies_.size() - 1;
  SEMMAP_RETURN_IF_ERROR(Restart());
  const Testimony& told = testimonies_[index];
  Aftermath(server_->address(), tally).Inspect(told, options_.pictures);
  if (told.Durable(told.tracked).size() > 1) last_drive_ = index;
  return absl::OkStatus();
}

// Goes on with the map of a drive that was killed before.
absl::Status Rounds::KillDuringExtension(Tally* tally) {
  const std::string map = last_drive_ ? testimonies_[*last_drive_].map : kBase;
  KillDrive(street_, map, v1::SESSION_MODE_EXTEND, DrawMoment(street_, 0, 1), tally);
  SEMMAP_RETURN_IF_ERROR(Restart());
  Aftermath aftermath(server_->address(), tally);
  aftermath.Inspect(testimonies_.back(), options_.pictures);
  if (last_drive_) aftermath.InspectContents(testimonies_[*last_drive_], map, options_.pictures);
  return absl::OkStatus();
}

absl::Status Rounds::KillDuringLoop(Tally* tally) {
  Moment moment = loop_begins_;
  moment.later = Draw() * loop_time_;
  KillDrive(round_, absl::StrCat("loop-", kills_), v1::SESSION_MODE_MAP, moment, tally);
  SEMMAP_RETURN_IF_ERROR(Restart());
  Aftermath(server_->address(), tally).Inspect(testimonies_.back(), options_.pictures);
  return absl::OkStatus();
}

absl::Status Rounds::KillDuringWork(std::unique_ptr<Work> work, Tally* tally) {
  SEMMAP_ASSIGN_OR_RETURN(const auto connection, Connect(server_->address()));
  client::Client client(connection);
  const std::string name = absl::StrCat("work-", kills_);
  SEMMAP_RETURN_IF_ERROR(work->Prepare(client, name));
  const absl::Time begin = absl::Now();
  SEMMAP_RETURN_IF_ERROR(work->Run(client, name));
  const absl::Duration whole = kSlower * (absl::Now() - begin);
  SEMMAP_RETURN_IF_ERROR(work->Undo(client, name));
  SEMMAP_RETURN_IF_ERROR(work->Prepare(client, name));

  Vehicle vehicle(street_, server_->address(), absl::StrCat("beside-", kills_), v1::SESSION_MODE_MAP);
  vehicle.WaitForAnswers(DrawMoment(street_, 0.1, 0.7).answers);
  absl::Status done;
  std::thread worker([&] { done = work->Run(client, name); });
  absl::SleepFor(Draw() * whole);
  server_->Stop(SIGKILL);
  work->Kill();
  worker.join();
  testimonies_.push_back(vehicle.Finish());
  if (!done.ok()) ++tally->inside;

  SEMMAP_RETURN_IF_ERROR(Restart());
  Aftermath aftermath(server_->address(), tally);
  work->Inspect(&aftermath, name, done.ok());
  aftermath.Inspect(testimonies_.back(), options_.pictures);
  aftermath.InspectMap(kBase);
  aftermath.InspectContents(base_, kBase, 1);
  return absl::OkStatus();
}

absl::Status Rounds::KillDuringMigration(Tally* tally) {
  const std::string data = options_.directory + "/old";
  SEMMAP_RETURN_IF_ERROR(MakeDirectory(data));
  fs::copy_file(options_.directory + "/version1.db", data + "/semmap.db");
  {
    DaemonProcess process(ServerProcess::Arguments(options_.config, data), data + "/semmapd.log");
    if (!WaitForLog(data + "/semmapd.log", kMigrationBegins))
      return absl::InternalError("nothing is migrated");
    absl::SleepFor(Draw() * migration_time_);
    process.Stop(SIGKILL);
  }
  // Of a copy: to look at the file would be to recover it.
  const std::string copy = options_.directory + "/look";
  SEMMAP_RETURN_IF_ERROR(MakeDirectory(copy));
  for (const char* file : {"/semmap.db", "/semmap.db-wal"}) {
    if (fs::exists(data + file)) fs::copy_file(data + file, copy + file);
  }
  SEMMAP_ASSIGN_OR_RETURN(const int64_t version, SchemaVersion(copy + "/semmap.db"));
  if (version == 1) ++tally->inside;

  const ServerProcess server(options_.config, data);
  if (server.address().empty()) {
    tally->failures.push_back("the old database does not open after a kill");
    return absl::OkStatus();
  }
  Aftermath aftermath(server.address(), tally);
  for (int i = -1; i < kOldCopies; ++i) {
    const std::string map = i < 0 ? kBase : absl::StrCat(kBase, i);
    if (!aftermath.InspectMap(map)) aftermath.Fail(map + " is not in the migrated database");
    aftermath.InspectContents(base_, map, 1);
  }
  return absl::OkStatus();
}

absl::Status Rounds::KillIn(Phase phase, Tally* tally) {
  switch (phase) {
    case Phase::kDrive:
      return KillDuringDrive(tally);
    case Phase::kExtend:
      return KillDuringExtension(tally);
    case Phase::kLoop:
      return KillDuringLoop(tally);
    case Phase::kCopy:
      return KillDuringWork(CopyWork(base_), tally);
    case Phase::kImport:
      return KillDuringWork(ImportWork(base_, base_file_), tally);
    case Phase::kMerge:
      return KillDuringWork(MergeWork(base_), tally);
    case Phase::kBackup:
      return KillDuringWork(BackupWork(base_, options_.config, data_), tally);
    case Phase::kMigration:
      return KillDuringMigration(tally);
  }
  return absl::InternalError("no such phase");
}

absl::Status Rounds::KillOnce() {
  const auto turn = static_cast<size_t>(kills_) % kPhases.size();
  if (turn == 0) {
    SEMMAP_RETURN_IF_ERROR(Finish());
    SEMMAP_RETURN_IF_ERROR(BeginStore());
  }
  const Phase phase = kPhases[turn];
  Tally tally;
  const absl::Status status = KillIn(phase, &tally);
  ++kills_;
  ++tally.kills;
  for (std::string& failure : tally.failures)
    failure = absl::StrCat("kill ", kills_, ", ", NameOf(phase), ": ", failure);
  tallies_[phase].Add(tally);
  return status;
}

absl::Status Rounds::Finish() {
  if (server_ == nullptr || testimonies_.empty()) return absl::OkStatus();
  Aftermath aftermath(server_->address(), &last_look_);
  for (const Testimony& told : testimonies_) {
    if (told.session.empty()) continue;
    aftermath.InspectMap(told.map);
    aftermath.InspectContents(told, told.map, 1);
  }
  server_->Stop(SIGTERM);
  server_.reset();
  return absl::OkStatus();
}

}  // namespace semmap::kill_test
