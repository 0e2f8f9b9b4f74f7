// A process is killed while it writes: what it was told to be durable is there, and the map is sound.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <random>
#include <thread>

#include "delta_generator.h"
#include "storage_test_support.h"

namespace semmap::storage {
namespace {

constexpr uint32_t kSeed = 77;
constexpr size_t kKeypoints = 400;

// Goes on with the drive from where the database is; writes the version of each delta to `acknowledge` after
// Apply.
[[noreturn]] void DriveUntilKilled(const std::string& path, int acknowledge) {
  const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path));
  if (store == nullptr) _exit(2);
  absl::StatusOr<MapInfo> map = store->GetMap("m");
  if (!map.ok()) map = store->CreateMap(MapNamed("m"));
  absl::StatusOr<SessionInfo> session = store->GetSession("s");
  if (!session.ok()) session = store->StartSession(SessionOf(map->id, "s"));
  if (!map.ok() || !session.ok()) _exit(3);
  DeltaGenerator generator(kSeed, kKeypoints);
  for (uint64_t version = 0; version < session->last_delta_version; ++version) generator.Next();
  while (true) {
    const MapDelta delta = generator.Next();
    if (!store->Apply(map->id, session->id, delta).ok()) _exit(4);
    if (write(acknowledge, &delta.version, sizeof(delta.version)) != sizeof(delta.version)) _exit(5);
    if (delta.version % 40 == 0) {
      // Deletion is killed, too.
      const absl::StatusOr<MapInfo> other =
          store->CreateMap(MapNamed("other" + std::to_string(delta.version)));
      if (!other.ok() || !store->DeleteMap(other->id).ok()) _exit(6);
      // So are a copy and a backup.
      const absl::StatusOr<MapInfo> copy =
          store->CopyMap(map->id, "copy" + std::to_string(delta.version), 1, nullptr);
      if (!copy.ok() || !store->DeleteMap(copy->id).ok()) _exit(7);
      std::filesystem::remove(path + ".backup");
      if (!store->Backup(path + ".backup", nullptr).ok()) _exit(8);
    }
  }
}

// Starts a driver, kills it after `run_for`, and returns the last version it acknowledged (0: none).
uint64_t KillADrive(const std::string& path, std::chrono::microseconds run_for) {
  int pipe_ends[2];
  EXPECT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    close(pipe_ends[0]);
    DriveUntilKilled(path, pipe_ends[1]);
  }
  close(pipe_ends[1]);
  std::this_thread::sleep_for(run_for);
  EXPECT_EQ(kill(child, SIGKILL), 0);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << "ended by itself, status " << status;
  uint64_t last = 0;
  uint64_t version = 0;
  while (read(pipe_ends[0], &version, sizeof(version)) == sizeof(version)) last = version;
  close(pipe_ends[0]);
  return last;
}

// The map is as some number of deltas left it, at least as many as were acknowledged.
void ExpectSound(const std::string& path, uint64_t acknowledged) {
  const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path));
  ASSERT_NE(store, nullptr);
  const absl::StatusOr<SessionInfo> session = store->GetSession("s");
  if (acknowledged == 0 && !session.ok()) return;
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_GE(session->last_delta_version, acknowledged);
  EXPECT_LE(session->last_delta_version, acknowledged + 1);
  EXPECT_EQ(Findings(*store, session->map), "");
  // Only whole copies are seen, and only whole backups have their name.
  const absl::StatusOr<std::vector<MapInfo>> maps = store->ListMaps({});
  ASSERT_TRUE(maps.ok()) << maps.status();
  for (const MapInfo& map : *maps) EXPECT_EQ(Findings(*store, map.id), "") << map.name;
  if (std::filesystem::exists(path + ".backup")) {
    const std::unique_ptr<MapStore> backup = OpenOrDie(ConfigFor(path + ".backup"));
    ASSERT_NE(backup, nullptr);
    EXPECT_EQ(Findings(*backup, session->map), "");
  }
  DeltaGenerator generator(kSeed, kKeypoints);
  for (uint64_t version = 0; version < session->last_delta_version; ++version) generator.Next();
  const ModelMap& model = generator.model();
  const std::vector<KeyFrameEntry> keyframes = AllKeyFrames(*store, session->map, {.with_features = true});
  ASSERT_EQ(keyframes.size(), model.keyframes.size());
  for (const KeyFrameEntry& keyframe : keyframes) {
    const KeyFrameRecord& expected = model.keyframes.at(keyframe.record.id.value());
    EXPECT_TRUE(SamePose(keyframe.record.map_from_camera, expected.map_from_camera));
    EXPECT_TRUE(SameFeatures(*keyframe.record.features, *expected.features));
  }
  const std::vector<MapPointRecord> points = AllPoints(*store, session->map);
  ASSERT_EQ(points.size(), model.points.size());
  for (const MapPointRecord& point : points) EXPECT_TRUE(SamePoint(point, model.points.at(point.id.value())));
  EXPECT_EQ(Trajectory(*store, session->map).size(), model.frames.size());
}

TEST(Crash, KilledDrivesLeaveSoundMapsWithEveryAcknowledgedDelta) {
  TempDir dir;
  std::mt19937 random(3);
  uint64_t acknowledged = 0;
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    const auto run_for = std::chrono::microseconds(20000 + random() % 150000);
    acknowledged = std::max(acknowledged, KillADrive(dir.File("maps.db"), run_for));
    ExpectSound(dir.File("maps.db"), acknowledged);
    if (testing::Test::HasFatalFailure()) return;
  }
  // The kills came in the midst of work, not before it.
  EXPECT_GT(acknowledged, 20);
}

}  // namespace
}  // namespace semmap::storage
