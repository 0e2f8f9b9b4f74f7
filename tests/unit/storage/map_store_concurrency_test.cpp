// Readers and writers at once: snapshots are whole, and nobody waits for a reader.
#include <atomic>
#include <thread>

#include "delta_generator.h"
#include "slam/common/notification.h"
#include "storage_test_support.h"

namespace semmap::storage {
namespace {

constexpr size_t kPointsPerDelta = 7;

// Adds a keyframe, kPointsPerDelta points and a frame; takes the version for all ids.
MapDelta StepDelta(uint64_t version) {
  MapDelta delta;
  delta.version = version;
  delta.added_keyframes.push_back(KeyFrameWith(version, 16));
  KeyFrameObservations observations{KeyFrameId(version), std::vector<MapPointId>(16)};
  for (size_t i = 0; i < kPointsPerDelta; ++i) {
    MapPointRecord point = PointAt(version * kPointsPerDelta + i, {static_cast<double>(version), 0, 0});
    point.reference_keyframe = KeyFrameId(version);
    point.observation_count = 1;
    observations.point_of_keypoint[i] = point.id;
    delta.upserted_points.push_back(point);
  }
  delta.observations.push_back(observations);
  delta.frames.push_back({version, static_cast<TimestampNs>(version), KeyFrameId(version), SE3()});
  return delta;
}

class MapStoreConcurrency : public testing::Test {
 protected:
  MapStoreConcurrency() : store_(OpenOrDie(ConfigFor(dir_.File("maps.db")))) {}

  std::pair<MapId, SessionId> Start(const std::string& name) {
    const MapId map = store_->CreateMap(MapNamed(name))->id;
    return {map, store_->StartSession(SessionOf(map, name))->id};
  }

  void Drive(MapId map, SessionId session, uint64_t deltas) {
    for (uint64_t version = 1; version <= deltas; ++version) {
      const absl::Status status = store_->Apply(map, session, StepDelta(version));
      ASSERT_TRUE(status.ok()) << status;
    }
  }

  TempDir dir_;
  std::unique_ptr<MapStore> store_;
};

TEST_F(MapStoreConcurrency, ReadersSeeWholeDeltas) {
  const auto [map, session] = Start("a");
  std::atomic<bool> done = false;
  std::atomic<int> reads = 0;
  std::vector<std::thread> readers;
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&, id = map] {
      while (!done) {
        EXPECT_EQ(PointIds(*store_, id).size() % kPointsPerDelta, 0);
        const absl::StatusOr<MapInfo> info = store_->GetMap(id);
        EXPECT_EQ(info->point_count, kPointsPerDelta * info->keyframe_count);
        EXPECT_EQ(info->version, info->keyframe_count);
        const absl::StatusOr<MapSummary> summary = store_->Summarize(id);
        EXPECT_EQ(summary->frame_count, summary->map.keyframe_count);
        ++reads;
      }
    });
  }
  Drive(map, session, 150);
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_GT(reads, 3);
  EXPECT_EQ(Findings(*store_, map), "");
}

TEST_F(MapStoreConcurrency, ReaderInItsVisitorBlocksNoWriter) {
  const auto [map, session] = Start("a");
  Drive(map, session, 1);
  Notification reading;
  Notification written;
  std::thread reader([&, id = map] {
    size_t seen = 0;
    const absl::Status status = store_->ForEachMapPoint(id, {}, [&](const MapPointRecord&) {
      if (!reading.HasBeenNotified()) reading.Notify();
      written.WaitForNotification();
      ++seen;
      return true;
    });
    EXPECT_TRUE(status.ok()) << status;
    // What came meanwhile is not in its snapshot.
    EXPECT_EQ(seen, kPointsPerDelta);
  });
  reading.WaitForNotification();
  EXPECT_TRUE(store_->Apply(map, session, StepDelta(2)).ok());
  EXPECT_EQ(PointIds(*store_, map).size(), 2 * kPointsPerDelta);
  written.Notify();
  reader.join();
}

TEST_F(MapStoreConcurrency, SessionsWriteAtOnce) {
  std::vector<std::pair<MapId, SessionId>> drives;
  for (const char* name : {"a", "b", "c", "d"}) drives.push_back(Start(name));
  std::vector<std::thread> writers;
  for (const auto& [map, session] : drives) {
    writers.emplace_back([this, map = map, session = session] { Drive(map, session, 40); });
  }
  for (std::thread& writer : writers) writer.join();
  for (const auto& [map, session] : drives) {
    EXPECT_EQ(store_->GetMap(map)->version, 40);
    EXPECT_EQ(Findings(*store_, map), "");
  }
}

TEST_F(MapStoreConcurrency, MapIsDeletedBesideADrive) {
  const auto [old_map, old_session] = Start("old");
  Drive(old_map, old_session, 150);
  const auto [map, session] = Start("new");
  std::thread deleter([this, id = old_map] { EXPECT_TRUE(store_->DeleteMap(id).ok()); });
  Drive(map, session, 50);
  deleter.join();
  EXPECT_TRUE(absl::IsNotFound(store_->GetMap("old").status()));
  EXPECT_EQ(Findings(*store_, map), "");
}

TEST_F(MapStoreConcurrency, TwoStoresOnOneFile) {
  const auto [map, session] = Start("a");
  const std::unique_ptr<MapStore> other = OpenOrDie(ConfigFor(dir_.File("maps.db")));
  const auto other_session = other->StartSession(SessionOf(map, "other"));
  ASSERT_TRUE(other_session.ok());
  std::thread writer([&, id = map, session_id = session] { Drive(id, session_id, 30); });
  for (uint64_t version = 1; version <= 30; ++version) {
    MapDelta delta = StepDelta(1000 + version);
    const absl::Status status = other->Apply(map, other_session->id, delta);
    ASSERT_TRUE(status.ok()) << status;
  }
  writer.join();
  EXPECT_EQ(other->GetMap(map)->keyframe_count, 60);
  EXPECT_EQ(Findings(*store_, map), "");
}

}  // namespace
}  // namespace semmap::storage
