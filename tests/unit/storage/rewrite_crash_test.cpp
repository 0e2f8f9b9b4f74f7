// A process is killed while it makes a map over: the map is as it was, or as it should become, and sound.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <random>
#include <string>

#include "storage/joined_map_loader.h"
#include "storage_test_support.h"
#include "tests/support/ring_world.h"

namespace semmap::storage {
namespace {

using semmap::testing::DriveRing;
using semmap::testing::RingWorld;

constexpr int kKeyFrames = 12;

void StoreDrive(MapStore* store, const std::string& name, int first) {
  const MappingCamera camera = RingWorld::Camera(SensorType::kStereo);
  NewMap new_map = MapNamed(name);
  new_map.rig = camera.rig;
  const MapId id = store->CreateMap(new_map)->id;
  NewSession session = SessionOf(id, "drive-" + name);
  session.rig = camera.rig;
  const SessionId session_id = store->StartSession(session)->id;
  MapDelta delta = DriveRing(RingWorld(1), camera, kKeyFrames, 0.13, {}, first).TakeDelta();
  delta.version = 1;
  ASSERT_TRUE(store->Apply(id, session_id, delta).ok());
}

// Joins the source to the target again and again; each time the target has more. Writes a byte to `tell`
// after each step.
[[noreturn]] void JoinUntilKilled(const std::string& path, int tell) {
  const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path));
  if (store == nullptr) _exit(2);
  while (true) {
    const auto target = store->GetMap("target");
    const auto source = store->GetMap("source");
    if (!target.ok() || !source.ok()) _exit(3);
    auto maps =
        LoadJoinedMaps(*store, target->id, source->id, RingWorld::ScaleInfo(), size_t{1} << 30, {}, false);
    if (!maps.ok()) _exit(4);
    for (const auto& [id, keyframe] : maps->map.keyframes()) maps->map.SetPose(id, keyframe.camera_from_map);
    for (const auto& [id, point] : maps->map.points()) maps->map.SetPosition(id, point.position_in_map);
    MapRewrite rewrite;
    rewrite.map = {target->id, target->version};
    rewrite.joined = MapRewrite::Basis{source->id, source->version};
    rewrite.changes = maps->map.TakeDelta();
    const auto tell_step = [tell](double) { return write(tell, "", 1) == 1; };
    if (!store->RewriteMap(rewrite, tell_step).ok()) _exit(5);
  }
}

// Lets a process join the maps and kills it some time after so many steps.
void KillAfterSteps(const std::string& path, size_t steps) {
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) JoinUntilKilled(path, pipe_ends[1]);
  close(pipe_ends[1]);
  char byte = 0;
  while (steps > 0 && read(pipe_ends[0], &byte, 1) == 1) --steps;
  EXPECT_EQ(kill(child, SIGKILL), 0);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << "ended by itself, status " << WEXITSTATUS(status);
  close(pipe_ends[0]);
}

TEST(RewriteCrash, KilledMergesLeaveWholeMaps) {
  TempDir dir;
  const std::string path = dir.File("maps.db");
  {
    const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path));
    StoreDrive(store.get(), "target", 0);
    StoreDrive(store.get(), "source", 4);
  }
  std::mt19937 random(5);
  uint64_t joined = 0;
  for (int round = 0; round < 15; ++round) {
    SCOPED_TRACE(round);
    KillAfterSteps(path, 1 + random() % 80);
    const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path));
    ASSERT_NE(store, nullptr);
    const std::vector<MapInfo> maps = *store->ListMaps({});
    ASSERT_EQ(maps.size(), 2U);
    for (const MapInfo& map : maps) {
      EXPECT_EQ(Findings(*store, map.id), "") << map.name;
      EXPECT_EQ(map.keyframe_count % kKeyFrames, 0U) << "no part of a map is joined";
      joined = std::max(joined, map.keyframe_count / kKeyFrames);
    }
  }
  // The kills came in the midst of work, not before it.
  EXPECT_GT(joined, 1U);
}

}  // namespace
}  // namespace semmap::storage
