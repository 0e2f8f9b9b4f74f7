// Maps of simulated drives are joined, optimized and pruned by the handlers: everything but images and
// network.
#include <algorithm>
#include <memory>
#include <vector>

#include "operation_fixture.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/watch_map.h"
#include "tests/support/ring_world.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap::server {
namespace {

using semmap::testing::DriveRing;
using semmap::testing::RingWorld;

constexpr double kStep = 2 * 3.14159265358979 / 48;
constexpr int kKeyFrames = 20;
constexpr int kFirstOfSource = 10;

class StoredDrivesTest : public OperationTest {
 protected:
  StoredDrivesTest() { context_.vocabulary = testing::RandomVocabulary(12, 5); }

  // A drive from step `first` on, with a frame half a metre ahead of each keyframe.
  storage::MapInfo StoreDrive(const std::string& name, SensorType sensor, int first, double unit = 1) {
    const MappingCamera camera = RingWorld::Camera(sensor);
    const auto map = store_->CreateMap({name, 1, camera.rig, sensor != SensorType::kMono});
    EXPECT_TRUE(map.ok()) << map.status();
    const auto session = store_->StartSession({map->id, "drive-" + name, "car", 1, camera.rig});
    EXPECT_TRUE(session.ok()) << session.status();
    MapDelta delta = DriveRing(RingWorld(1), camera, kKeyFrames, kStep, {}, first, unit).TakeDelta();
    delta.version = 1;
    for (const KeyFrameRecord& keyframe : delta.added_keyframes) {
      delta.frames.push_back({keyframe.sequence, keyframe.timestamp, keyframe.id,
                              SE3(Eigen::Quaterniond::Identity(), {0, 0, 0.5 * unit})});
    }
    EXPECT_TRUE(store_->Apply(map->id, session->id, delta).ok());
    EXPECT_TRUE(store_->EndSession(map->id, session->id, 2, {kKeyFrames, kKeyFrames}).ok());
    return *store_->GetMap(name);
  }

  v1::MergeMapsRequest MergeRequest(bool validate_only, bool delete_source) const {
    v1::MergeMapsRequest request;
    request.set_target("maps/east");
    request.set_source("maps/west");
    request.set_validate_only(validate_only);
    request.set_delete_source(delete_source);
    return request;
  }

  v1::MergeMapsResponse Merged(const v1::MergeMapsRequest& request) {
    v1::MergeMapsResponse response;
    const v1::Operation operation = Finished(MergeMaps(context_, request));
    EXPECT_TRUE(operation.response().UnpackTo(&response)) << operation.error().message();
    return response;
  }

  // The greatest distance of a frame of the map that begins at step 0 from the truth, of both drives.
  double WorstFrame(storage::MapId map) {
    double worst = 0;
    const absl::Status status =
        store_->ForEachTrajectoryPose(map, {}, [&](const storage::TrajectoryPose& pose) {
          const int first = pose.session == storage::SessionId(1) ? 0 : kFirstOfSource;
          const double angle = (first + static_cast<double>(pose.sequence) - 1) * kStep;
          const Eigen::Vector3d truth = RingWorld::WorldFromCamera(angle) * Eigen::Vector3d(0, 0, 0.5);
          worst = std::max(worst, (pose.map_from_camera.translation() - truth).norm());
          return true;
        });
    EXPECT_TRUE(status.ok()) << status;
    return worst;
  }
};

TEST_F(StoredDrivesTest, TwoDrivesBecomeOne) {
  const storage::MapInfo east = StoreDrive("east", SensorType::kStereo, 0);
  const storage::MapInfo west = StoreDrive("west", SensorType::kStereo, kFirstOfSource);
  const auto watcher = std::make_shared<MapWatcher>(1000, [] {});
  watchers_.Add(east.id, watcher);
  const v1::MergeMapsResponse dry = Merged(MergeRequest(true, true));
  EXPECT_EQ(store_->GetMap("east")->version, east.version);
  EXPECT_EQ(store_->GetMap("west")->version, west.version);
  EXPECT_FALSE(watcher->HasNews());
  EXPECT_EQ(dry.map().keyframe_count(), kKeyFrames) << "as it was";
  EXPECT_GE(dry.overlapping_keyframes(), 8);
  EXPECT_GT(dry.fused_points(), 200);
  const SE3 truth = RingWorld::WorldFromCamera(kFirstOfSource * kStep);
  const v1::Vector3& t = dry.target_from_source().pose().translation();
  EXPECT_LT((Eigen::Vector3d(t.x(), t.y(), t.z()) - truth.translation()).norm(), 0.1);
  EXPECT_EQ(dry.target_from_source().scale(), 1);

  const v1::MergeMapsResponse merged = Merged(MergeRequest(false, true));
  EXPECT_EQ(merged.fused_points(), dry.fused_points());
  EXPECT_LT(merged.reprojection_rms_px(), dry.reprojection_rms_px());
  EXPECT_LT(merged.reprojection_rms_px(), 1);
  EXPECT_EQ(merged.map().keyframe_count(), 2 * kKeyFrames);
  EXPECT_LE(merged.map().point_count(),
            static_cast<int64_t>(east.point_count + west.point_count) - merged.fused_points());
  EXPECT_TRUE(absl::IsNotFound(store_->GetMap("west").status()));
  const storage::MapInfo joined = *store_->GetMap("east");
  EXPECT_GT(joined.version, east.version);
  EXPECT_TRUE(store_->CheckIntegrity(joined.id, 10)->empty());
  EXPECT_EQ(store_->GetSession("drive-west")->map, joined.id);
  EXPECT_LT(WorstFrame(joined.id), 0.1);
  EXPECT_TRUE(watcher->Take(10).reset);
  EXPECT_FALSE(sessions_->IsMapInUse("east"));
}

TEST_F(StoredDrivesTest, OneEyeIsScaledToMetresAndKeepsItsFrames) {
  StoreDrive("east", SensorType::kStereo, 0);
  StoreDrive("west", SensorType::kMono, kFirstOfSource, 3);
  const v1::MergeMapsResponse merged = Merged(MergeRequest(false, false));
  EXPECT_NEAR(merged.target_from_source().scale(), 1.0 / 3, 0.01);
  const storage::MapInfo joined = *store_->GetMap("east");
  EXPECT_TRUE(joined.scale_known);
  EXPECT_TRUE(store_->CheckIntegrity(joined.id, 10)->empty());
  EXPECT_LT(WorstFrame(joined.id), 0.2);
  EXPECT_EQ(store_->GetMap("west")->keyframe_count, static_cast<uint64_t>(kKeyFrames)) << "stays";
}

TEST_F(StoredDrivesTest, AMonocularTargetKeepsItsUnit) {
  StoreDrive("east", SensorType::kMono, 0);
  StoreDrive("west", SensorType::kStereo, kFirstOfSource);
  const v1::MergeMapsResponse merged = Merged(MergeRequest(false, false));
  EXPECT_NEAR(merged.target_from_source().scale(), 1, 0.03);
  const storage::MapInfo joined = *store_->GetMap("east");
  EXPECT_FALSE(joined.scale_known);
  EXPECT_TRUE(store_->CheckIntegrity(joined.id, 10)->empty());
  EXPECT_LT(WorstFrame(joined.id), 0.2);
}

TEST_F(StoredDrivesTest, AnchorOfTheSourceServesATargetWithoutOne) {
  StoreDrive("east", SensorType::kStereo, 0);
  const storage::MapInfo west = StoreDrive("west", SensorType::kStereo, kFirstOfSource);
  storage::GeoAnchor anchor;
  anchor.latitude_deg = 48;
  anchor.enu_from_map = Sim3{1, RingWorld::WorldFromCamera(kFirstOfSource * kStep)};
  ASSERT_TRUE(store_->SetAnchor(west.id, anchor).ok());
  Merged(MergeRequest(false, true));
  const storage::MapInfo joined = *store_->GetMap("east");
  ASSERT_TRUE(joined.anchor.has_value());
  EXPECT_EQ(joined.anchor->latitude_deg, 48);
  // What the anchor says of west's frame, it says of the world's, which east begins in.
  EXPECT_LT(joined.anchor->enu_from_map.rigid.translation().norm(), 0.1);
}

TEST_F(StoredDrivesTest, ACancelledMergeChangesNothing) {
  const storage::MapInfo east = StoreDrive("east", SensorType::kStereo, 0);
  StoreDrive("west", SensorType::kStereo, kFirstOfSource);
  const auto started = MergeMaps(context_, MergeRequest(false, true));
  ASSERT_TRUE(started.ok()) << started.status();
  v1::CancelOperationRequest cancel;
  cancel.set_name(started->name());
  ASSERT_TRUE(CancelOperation(context_, cancel).ok());
  const v1::Operation operation = Finished(started);
  ASSERT_TRUE(operation.has_error());
  EXPECT_EQ(operation.error().code(), static_cast<int>(absl::StatusCode::kCancelled));
  EXPECT_EQ(store_->GetMap("east")->id, east.id);
  EXPECT_EQ(store_->GetMap("east")->version, east.version);
  EXPECT_TRUE(store_->GetMap("west").ok());
}

TEST_F(StoredDrivesTest, AWatcherFollowsAMapThatIsMadeOver) {
  StoreDrive("east", SensorType::kStereo, 0);
  v1::WatchMapRequest request;
  request.set_map("maps/east");
  auto source = WatchSource::Make(context_, request, [] {});
  ASSERT_TRUE(source.ok()) << source.status();
  const auto tell = [&] {
    std::vector<v1::WatchMapResponse> told;
    while ((*source)->HasNews()) {
      v1::WatchMapResponse response;
      const auto more = (*source)->Next(&response);
      EXPECT_TRUE(more.ok()) << more.status();
      if (!more.ok() || !*more) break;
      told.push_back(response);
    }
    return told;
  };
  tell();
  v1::PruneMapRequest prune;
  prune.set_name("maps/east");
  prune.set_max_keyframes(12);
  ASSERT_TRUE(Finished(PruneMap(context_, prune)).has_response());
  const auto told = tell();
  ASSERT_FALSE(told.empty());
  EXPECT_TRUE(told.front().reset());
  int keyframes = 0;
  for (const v1::WatchMapResponse& response : told) keyframes += response.keyframes_size();
  EXPECT_EQ(keyframes, 12);
  EXPECT_EQ(told.back().map_version(), store_->GetMap("east")->version);
}

TEST_F(StoredDrivesTest, OptimizeLowersTheError) {
  const storage::MapInfo east = StoreDrive("east", SensorType::kStereo, 0);
  const auto session = store_->StartSession({east.id, "pusher", "nobody", 1, east.rig});
  MapDelta delta;
  delta.version = 1;
  ASSERT_TRUE(store_
                  ->ForEachKeyFrame(east.id, {},
                                    [&](const storage::KeyFrameEntry& entry) {
                                      if (entry.record.id.value() % 2 == 1) return true;
                                      const SE3 push(Eigen::Quaterniond::Identity(), {0.1, 0, 0.05});
                                      delta.moved_keyframes.push_back({entry.record.id,
                                                                       entry.record.map_from_camera * push,
                                                                       entry.record.parent});
                                      return true;
                                    })
                  .ok());
  ASSERT_TRUE(store_->Apply(east.id, session->id, delta).ok());
  const double before = WorstFrame(east.id);
  ASSERT_GT(before, 0.1);
  v1::OptimizeMapRequest request;
  request.set_name("maps/east");
  const v1::Operation operation = Finished(OptimizeMap(context_, request));
  ASSERT_TRUE(operation.has_response()) << operation.error().message();
  const v1::OptimizeReport& report = operation.metadata().optimize();
  EXPECT_LT(report.final_rms_px(), 0.5 * report.initial_rms_px());
  const storage::MapInfo optimized = *store_->GetMap("east");
  EXPECT_LT(WorstFrame(optimized.id), 0.5 * before);
  EXPECT_TRUE(store_->CheckIntegrity(optimized.id, 10)->empty());
}

}  // namespace
}  // namespace semmap::server
