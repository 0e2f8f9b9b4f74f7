#include "storage/map_loader.h"

#include "storage_test_support.h"
#include "tests/support/ring_world.h"

namespace semmap::storage {
namespace {

using semmap::testing::DriveRing;
using semmap::testing::RingWorld;

constexpr size_t kEnough = size_t{1} << 30;
constexpr double kStep = 0.13;

// A map of a drive, in memory and, by its deltas, in a store that was closed and opened again.
class MapLoaderTest : public ::testing::Test {
 protected:
  MapLoaderTest() : map_(DriveRing(RingWorld(1), camera_, 12, kStep, {})) {
    NewMap new_map = MapNamed("town");
    new_map.rig = camera_.rig;
    id_ = store_->CreateMap(new_map)->id;
    NewSession session = SessionOf(id_, "s1");
    session.rig = camera_.rig;
    session_ = store_->StartSession(session)->id;
    Store();
    ChangeMap();
    Store();
    store_.reset();
    store_ = OpenOrDie(ConfigFor(dir_.File("maps.db")));
  }

  // What a mapper does to a map after it was stored first.
  void ChangeMap() {
    map_.RemoveKeyFrame(KeyFrameId(5));
    map_.RemovePoint(map_.FindKeyFrame(KeyFrameId(3))->points[7]);
    const MapPointId moved = map_.FindKeyFrame(KeyFrameId(2))->points[3];
    map_.SetPosition(moved, map_.FindPoint(moved)->position_in_map + Eigen::Vector3d(0, 0, 0.1));
    map_.UpdateAppearance(moved);
    map_.SetPose(KeyFrameId(4),
                 SE3(ExpSO3({0, 0.01, 0}), {0.1, 0, 0}) * map_.FindKeyFrame(KeyFrameId(4))->camera_from_map);
  }

  void Store() {
    MapDelta delta = map_.TakeDelta();
    delta.version = ++version_;
    const absl::Status status = store_->Apply(id_, session_, delta);
    ASSERT_TRUE(status.ok()) << status;
  }

  absl::StatusOr<RestoredMap> Load(size_t max_bytes = kEnough) {
    return LoadMap(*store_, id_, RingWorld::ScaleInfo(), max_bytes);
  }

  TempDir dir_;
  std::unique_ptr<MapStore> store_ = OpenOrDie(ConfigFor(dir_.File("maps.db")));
  const MappingCamera camera_ = RingWorld::Camera(SensorType::kStereo);
  Map map_;
  MapId id_;
  SessionId session_;
  uint64_t version_ = 0;
};

TEST_F(MapLoaderTest, KeyFramesAreAsTheyWere) {
  const auto restored = Load();
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ(restored->info.version, 2U);
  ASSERT_EQ(restored->map.keyframes().size(), map_.keyframes().size());
  EXPECT_EQ(restored->map.newest_keyframe(), map_.newest_keyframe());
  for (const auto& [id, expected] : map_.keyframes()) {
    const KeyFrame* keyframe = restored->map.FindKeyFrame(id);
    ASSERT_NE(keyframe, nullptr) << id.value();
    EXPECT_EQ(keyframe->sequence, expected.sequence);
    EXPECT_EQ(keyframe->timestamp, expected.timestamp);
    const SE3 difference = keyframe->camera_from_map * expected.camera_from_map.Inverse();
    EXPECT_LT(difference.translation().norm(), 1e-12);
    EXPECT_LT(difference.RotationAngle(), 1e-12);
    EXPECT_EQ(keyframe->parent, expected.parent);
    EXPECT_EQ(keyframe->points, expected.points);
    EXPECT_EQ(keyframe->covisible, expected.covisible);
    EXPECT_EQ(keyframe->features->descriptors, expected.features->descriptors);
    EXPECT_EQ(keyframe->grid->bounds().max_x, expected.grid->bounds().max_x);
  }
}

TEST_F(MapLoaderTest, PointsAreAsTheyWere) {
  const auto restored = Load();
  ASSERT_TRUE(restored.ok()) << restored.status();
  ASSERT_EQ(restored->map.points().size(), map_.points().size());
  for (const auto& [id, expected] : map_.points()) {
    const MapPoint* point = restored->map.FindPoint(id);
    ASSERT_NE(point, nullptr) << id.value();
    EXPECT_EQ(point->position_in_map, expected.position_in_map);
    EXPECT_EQ(point->descriptor, expected.descriptor);
    EXPECT_LT((point->normal - expected.normal).norm(), 1e-3F) << "stored in fewer bits";
    EXPECT_NEAR(point->min_distance / expected.min_distance, 1, 1e-3) << "likewise";
    EXPECT_NEAR(point->max_distance / expected.max_distance, 1, 1e-3);
    EXPECT_EQ(point->reference_keyframe, expected.reference_keyframe);
    EXPECT_EQ(point->observations.size(), expected.observations.size());
  }
}

TEST_F(MapLoaderTest, AMapThatIsTooLargeIsRefused) {
  const auto restored = Load();
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_GT(restored->memory_bytes, 11 * sizeof(KeyFrame));
  EXPECT_TRUE(Load(restored->memory_bytes).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(Load(restored->memory_bytes - 1).status()));
  EXPECT_TRUE(absl::IsResourceExhausted(Load(100).status()));
}

TEST_F(MapLoaderTest, AMapThatIsNotThere) {
  EXPECT_TRUE(absl::IsNotFound(LoadMap(*store_, MapId(99), RingWorld::ScaleInfo(), kEnough).status()));
}

TEST_F(MapLoaderTest, ADanglingObservationIsDataLoss) {
  MapDelta delta;
  delta.version = ++version_;
  delta.removed_points.push_back(map_.FindKeyFrame(KeyFrameId(2))->points[3]);
  ASSERT_TRUE(store_->Apply(id_, session_, delta).ok());
  EXPECT_TRUE(absl::IsDataLoss(Load().status()));
}

}  // namespace
}  // namespace semmap::storage
