#include <cmath>
#include <vector>

#include "storage/appearance_codec.h"
#include "storage/geometry_codec.h"
#include "storage/observation_codec.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/spatial_index.h"
#include "storage_test_support.h"

// Databases as earlier versions left them are opened, upgraded and lose nothing.
namespace semmap::storage::sqlite {
namespace {

constexpr uint64_t kKeyFrames = 3;
constexpr uint64_t kPoints = 5;
constexpr size_t kKeypoints = 30;
constexpr double kCellSize = 4;
constexpr MapId kMap{1};
constexpr SessionId kSession{1};

// Features as schema version 1 packed them, every column in full.
Blob FeaturesV1(const FrameFeatures& features) {
  ByteWriter out;
  out.Put<uint8_t>(1);
  out.Put(static_cast<uint32_t>(features.size()));
  const auto column = [&](auto Keypoint::*field) {
    out.Put<uint8_t>(1);
    for (const Keypoint& keypoint : features.keypoints) out.Put(keypoint.*field);
  };
  column(&Keypoint::x);
  column(&Keypoint::y);
  column(&Keypoint::right_x);
  column(&Keypoint::depth);
  column(&Keypoint::angle);
  column(&Keypoint::octave);
  column(&Keypoint::semantic_class);
  out.PutArray(std::span<const Descriptor>(features.descriptors));
  return out.Take();
}

// Writes rows of schema version 1, as that version's writers did.
class VersionOne {
 public:
  explicit VersionOne(const std::string& path) {
    ConnectionOptions options;
    options.path = path;
    connection_ = *Connection::Open(options);
    EXPECT_TRUE(MigrateDatabase(*connection_, EmbeddedMigrations().first(1)).ok());
  }

  static KeyFrameRecord KeyFrame(uint64_t id) {
    KeyFrameRecord keyframe = KeyFrameWith(id, kKeypoints, {static_cast<double>(id), 0, 0});
    auto exact = std::make_shared<FrameFeatures>(*keyframe.features);
    for (Keypoint& keypoint : exact->keypoints) keypoint.x += 0.001F;  // finer than version 2 would keep
    keyframe.features = exact;
    return keyframe;
  }

  static MapPointRecord Point(uint64_t id) {
    MapPointRecord point = PointAt(id, {10.0 * static_cast<double>(id), 1, -1});
    point.observation_count = 1;
    return point;
  }

  void Fill() {
    static constexpr char kInsertMap[] =
        "INSERT INTO maps (map_id, name, created_at, rig, scale_known, keyframe_count, point_count, version, "
        "last_keyframe_id, last_point_id, last_session_id, cell_size) VALUES (1, 'old', 5, ?, 1, ?, ?, 7, ?, "
        "?, 1, ?)";
    static constexpr char kInsertSession[] =
        "INSERT INTO sessions (map_id, session_id, name, vehicle_id, started_at, rig, stored_frames, "
        "last_durable_sequence, last_delta_version) VALUES (1, 1, 'drive', 'car', 6, ?, 1, 30, 7)";
    const Blob rig = EncodeRig(StereoRig());
    Run(Query(*connection_, kInsertMap)
            .BindBlob(rig)
            .Bind(kKeyFrames)
            .Bind(kPoints)
            .Bind(kKeyFrames)
            .Bind(kPoints)
            .Bind(kCellSize));
    Run(Query(*connection_, kInsertSession).BindBlob(rig));
    for (uint64_t id = 1; id <= kKeyFrames; ++id) AddKeyFrame(KeyFrame(id));
    for (uint64_t id = 1; id <= kPoints; ++id) AddPoint(Point(id));
    AddFrame();
  }

 private:
  static void Run(Query& query) {
    const absl::Status status = query.Run();
    EXPECT_TRUE(status.ok()) << status;
  }

  void AddKeyFrame(const KeyFrameRecord& keyframe) {
    static constexpr char kInsert[] =
        "INSERT INTO keyframes (map_id, keyframe_id, session_id, sequence, timestamp, map_from_camera, "
        "keypoint_count, "
        "observation_count) VALUES (1, ?, 1, ?, ?, ?, ?, ?)";
    static constexpr char kInsertFeatures[] = "INSERT INTO keyframe_features VALUES (1, ?, ?)";
    static constexpr char kInsertObservations[] = "INSERT INTO keyframe_observations VALUES (1, ?, ?)";
    // The first keyframe sees all points.
    std::vector<MapPointId> sees(kKeypoints);
    for (uint64_t id = 1; keyframe.id.value() == 1 && id <= kPoints; ++id) sees[3 * id] = MapPointId(id);
    ByteWriter observations;
    const uint32_t count = EncodeObservations(sees, &observations);
    const auto pose = EncodePose(keyframe.map_from_camera);
    const Blob features = FeaturesV1(*keyframe.features);
    Run(Query(*connection_, kInsert)
            .Bind(keyframe.id)
            .Bind(keyframe.sequence)
            .Bind(keyframe.timestamp)
            .BindBlob(pose)
            .Bind(kKeypoints)
            .Bind(count));
    Run(Query(*connection_, kInsertFeatures).Bind(keyframe.id).BindBlob(features));
    Run(Query(*connection_, kInsertObservations).Bind(keyframe.id).BindBlob(observations.view()));
    const Cell cell = CellOf(keyframe.map_from_camera.translation(), kKeyFrameCell);
    EXPECT_TRUE(PutKeyFrameCell(*connection_, kMap, keyframe.id, cell).ok());
  }

  void AddPoint(const MapPointRecord& point) {
    static constexpr char kInsert[] =
        "INSERT INTO points (map_id, point_id, cell_key, session_id, x, y, z, semantic_class, "
        "class_confidence, "
        "observation_count, first_seen, last_seen, reference_keyframe_id, appearance) "
        "VALUES (1, ?, ?, 1, ?, ?, ?, ?, ?, 1, 0, 0, 1, ?)";
    ByteWriter appearance;
    EncodeAppearance(point, &appearance);
    const Cell cell = CellOf(point.position_in_map, kCellSize);
    Run(Query(*connection_, kInsert)
            .Bind(point.id)
            .Bind(PackCell(cell))
            .Bind(point.position_in_map.x())
            .Bind(point.position_in_map.y())
            .Bind(point.position_in_map.z())
            .Bind(point.semantic_class)
            .Bind(static_cast<double>(point.class_confidence))
            .BindBlob(appearance.view()));
    EXPECT_TRUE(AddPointCell(*connection_, kMap, cell).ok());
  }

  void AddFrame() {
    static constexpr char kInsert[] = "INSERT INTO frames VALUES (1, 1, 30, 3000, 3, ?)";
    const auto pose = EncodePose(SE3());
    Run(Query(*connection_, kInsert).BindBlob(pose));
  }

  std::unique_ptr<Connection> connection_;
};

class Upgrade : public testing::Test {
 protected:
  Upgrade() { VersionOne(path_).Fill(); }

  TempDir dir_;
  const std::string path_ = dir_.File("old.db");
};

TEST_F(Upgrade, FromVersionOneKeepsEverything) {
  const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path_));
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(Findings(*store, kMap), "");
  const absl::StatusOr<MapInfo> map = store->GetMap("old");
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->keyframe_count, kKeyFrames);
  EXPECT_EQ(map->version, 7U);
  EXPECT_FALSE(map->updated_at.has_value());
  for (uint64_t id = 1; id <= kKeyFrames; ++id) {
    const absl::StatusOr<KeyFrameEntry> keyframe = store->GetKeyFrame(kMap, KeyFrameId(id));
    ASSERT_TRUE(keyframe.ok()) << keyframe.status();
    EXPECT_TRUE(SameFeatures(*keyframe->record.features, *VersionOne::KeyFrame(id).features));
  }
  EXPECT_EQ(store->GetObservations(kMap, KeyFrameId(1))->point_of_keypoint[3], MapPointId(1));
  const std::vector<MapPointRecord> points = AllPoints(*store, kMap);
  ASSERT_EQ(points.size(), kPoints);
  for (const MapPointRecord& point : points)
    EXPECT_TRUE(SamePoint(point, VersionOne::Point(point.id.value())));
  EXPECT_EQ(Trajectory(*store, kMap).size(), 1U);
}

// Every version in between opens, too, and has no words yet.
TEST_F(Upgrade, FromEachVersion) {
  class Outline : public MapOutlineReader {
   public:
    absl::Status OnMap(const MapInfo&) override { return absl::OkStatus(); }
    absl::Status OnKeyFrame(KeyFrameOutline keyframe) override {
      EXPECT_FALSE(keyframe.words.has_value());
      EXPECT_EQ(keyframe.points.size(), keyframe.id.value() == 1 ? kPoints : 0);
      ++keyframes;
      return absl::OkStatus();
    }
    uint64_t keyframes = 0;
  };
  const size_t versions = EmbeddedMigrations().size();
  for (size_t version = 1; version < versions; ++version) {
    const std::string path = dir_.File("version" + std::to_string(version) + ".db");
    VersionOne(path).Fill();
    {
      ConnectionOptions options;
      options.path = path;
      ASSERT_TRUE(MigrateDatabase(**Connection::Open(options), EmbeddedMigrations().first(version)).ok());
    }
    const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path));
    ASSERT_NE(store, nullptr);
    EXPECT_EQ(Findings(*store, kMap), "") << version;
    Outline outline;
    ASSERT_TRUE(store->ReadOutline(kMap, 1, &outline).ok()) << version;
    EXPECT_EQ(outline.keyframes, kKeyFrames);
    EXPECT_EQ(AllPoints(*store, kMap).size(), kPoints) << version;
  }
}

TEST_F(Upgrade, AMapFileOfVersionOneIsImported) {
  const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(dir_.File("new.db")));
  const absl::StatusOr<MapInfo> map = store->ImportMap(path_, "imported", 9, nullptr);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->keyframe_count, kKeyFrames);
  EXPECT_EQ(Findings(*store, map->id), "");
  EXPECT_EQ(AllPoints(*store, map->id).size(), kPoints);
}

TEST_F(Upgrade, WhatWasUpgradedGrowsOn) {
  const std::unique_ptr<MapStore> store = OpenOrDie(ConfigFor(path_));
  ASSERT_NE(store, nullptr);
  MapDelta delta;
  delta.version = 8;
  delta.added_keyframes.push_back(KeyFrameWith(4, 10));
  delta.upserted_points = {PointAt(6, {0, 0, 0}), PointAt(2, {21, 1, -1})};
  delta.upserted_points[0].observation_count = 1;
  delta.upserted_points[1].observation_count = 2;
  std::vector<MapPointId> sees(kKeypoints);
  sees[1] = MapPointId(6);
  sees[2] = MapPointId(2);
  delta.observations.push_back({KeyFrameId(2), sees});
  const absl::Status status = store->Apply(kMap, kSession, delta);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(Findings(*store, kMap), "");
  EXPECT_EQ(AllPoints(*store, kMap).size(), kPoints + 1);
  EXPECT_TRUE(store->GetMap(kMap)->updated_at.has_value());
  EXPECT_TRUE(store->DeleteMap(kMap).ok());
}

}  // namespace
}  // namespace semmap::storage::sqlite
