// Stored maps that are joined, optimized and pruned, through the whole service with real SLAM.
#include <set>
#include <utility>

#include "room_fixture.h"
#include "storage/map_store.h"

namespace semmap {
namespace {

// Two drives through one room, each of which makes a map whose frame is its first picture's.
constexpr int kEastEnd = 26;
constexpr int kWestBegin = 14;
constexpr int kWestEnd = 40;
constexpr uint32_t kOtherRoom = 9;

class MapReworkTest : public RoomTest {
 protected:
  void SetUp() override {
    // Many keyframes in little time, of which none is left out.
    config_.slam.tracking.keyframe_ratio = config_.slam.tracking.keyframe_ratio_depth = 0.9;
    config_.slam.mapping.cull_redundancy = 1;
    StartRealServer();
  }

  void MakeMap(const std::string& name, int begin, int end, bool stereo = true, uint32_t room = kRoom) {
    ASSERT_GE(Drive(v1::SESSION_MODE_MAP, name, begin, end, stereo, room), (end - begin) * 3 / 4);
  }
  void MakeBoth(bool stereo = true) {
    MakeMap("east", 0, kEastEnd, stereo);
    MakeMap("west", kWestBegin, kWestEnd, stereo);
  }

  client::Client Ask() { return client::Client(Connect()); }

  static v1::MergeMapsRequest WestToEast() {
    v1::MergeMapsRequest request;
    request.set_target("east");
    request.set_source("west");
    return request;
  }

  // All that queries tell of a map, to the last byte.
  std::string ContentsOf(const std::string& map) {
    client::Client client(Connect());
    std::string contents = client.GetMap(map)->SerializeAsString();
    v1::QueryKeyFramesRequest keyframes;
    keyframes.set_map("maps/" + map);
    EXPECT_TRUE(client
                    .QueryKeyFrames(keyframes,
                                    [&](const v1::KeyFrame& keyframe) {
                                      contents += keyframe.SerializeAsString();
                                      return true;
                                    })
                    .ok());
    v1::QueryMapPointsRequest points;
    points.set_map("maps/" + map);
    EXPECT_TRUE(client
                    .QueryMapPoints(points,
                                    [&](const v1::QueryMapPointsResponse& response) {
                                      contents += response.SerializeAsString();
                                      return true;
                                    })
                    .ok());
    v1::GetTrajectoryRequest trajectory;
    trajectory.set_map("maps/" + map);
    EXPECT_TRUE(client
                    .GetTrajectory(trajectory,
                                   [&](const v1::GetTrajectoryResponse& response) {
                                     contents += response.SerializeAsString();
                                     return true;
                                   })
                    .ok());
    return contents;
  }

  // Distances of all stored frames of a map that begins with picture 0 from the truth, in order. The first
  // session began there, a second one with `second`.
  std::vector<double> TrajectoryErrors(const std::string& map, int second) {
    std::vector<double> errors;
    std::string first_session;
    v1::GetTrajectoryRequest request;
    request.set_map("maps/" + map);
    const absl::Status status =
        client::Client(Connect()).GetTrajectory(request, [&](const v1::GetTrajectoryResponse& response) {
          if (first_session.empty()) first_session = response.session();
          const int begin = response.session() == first_session ? 0 : second;
          const auto& columns = response.trajectory();
          for (int i = 0; i < columns.sequences_size(); ++i) {
            v1::Pose pose;
            pose.mutable_translation()->set_x(columns.poses(7 * i));
            pose.mutable_translation()->set_y(columns.poses(7 * i + 1));
            pose.mutable_translation()->set_z(columns.poses(7 * i + 2));
            errors.push_back(Error(pose, begin + static_cast<int>(columns.sequences(i)) - 1));
          }
          return true;
        });
    EXPECT_TRUE(status.ok()) << status;
    return errors;
  }
};

TEST_F(MapReworkTest, TwoMapsBecomeOne) {
  MakeBoth();
  const std::string east_before = ContentsOf("east");
  const std::string west_before = ContentsOf("west");
  v1::MergeMapsRequest request = WestToEast();
  request.set_validate_only(true);
  const auto dry = Ask().MergeMaps(request, nullptr);
  ASSERT_TRUE(dry.ok()) << dry.status();
  EXPECT_EQ(ContentsOf("east"), east_before);
  EXPECT_EQ(ContentsOf("west"), west_before);
  EXPECT_GE(dry->overlapping_keyframes(), 3);
  EXPECT_GT(dry->fused_points(), 50);
  EXPECT_GT(dry->reprojection_rms_px(), 0);
  const SE3 truth = FirstFromSecond(0, kWestBegin);
  const v1::Vector3& t = dry->target_from_source().pose().translation();
  EXPECT_LT((Eigen::Vector3d(t.x(), t.y(), t.z()) - truth.translation()).norm(), kBound);
  EXPECT_EQ(dry->target_from_source().scale(), 1);

  request.set_validate_only(false);
  request.set_delete_source(true);
  const auto merged = Ask().MergeMaps(request, nullptr);
  ASSERT_TRUE(merged.ok()) << merged.status();
  EXPECT_EQ(merged->fused_points(), dry->fused_points());
  EXPECT_LT(merged->reprojection_rms_px(), dry->reprojection_rms_px());
  EXPECT_EQ(client::ErrorReason(Ask().GetMap("west").status()), "MAP_NOT_FOUND");
  const v1::Map map = *Ask().GetMap("east");
  EXPECT_EQ(map.SerializeAsString(), merged->map().SerializeAsString());
  EXPECT_GT(map.version(), dry->map().version());
  ExpectSound("east");
  for (const int picture : {1, 8, 20, 30, 38}) ExpectFound("east", picture);
  const auto errors = TrajectoryErrors("east", kWestBegin);
  EXPECT_GE(errors.size(), static_cast<size_t>(kEastEnd + kWestEnd - kWestBegin - 2));
  for (size_t i = 0; i < errors.size(); ++i) EXPECT_LT(errors[i], kBound) << i;
  // The map is driven in and extended as any other.
  EXPECT_EQ(Drive(v1::SESSION_MODE_LOCALIZE, "east", 20, 36), 16);
  EXPECT_GE(Drive(v1::SESSION_MODE_EXTEND, "east", 30, 44), 13);
  ExpectSound("east");
}

TEST_F(MapReworkTest, MapsOfOneEyeAreScaled) {
  MakeBoth(false);
  const auto merged = Ask().MergeMaps(WestToEast(), nullptr);
  ASSERT_TRUE(merged.ok()) << merged.status();
  EXPECT_GE(merged->overlapping_keyframes(), 3);
  EXPECT_GT(merged->fused_points(), 50);
  ExpectSound("east");
  EXPECT_TRUE(Ask().GetMap("west").ok());
  EXPECT_EQ(Relocalize("east", 5, false)->result(), v1::RELOCALIZE_RESULT_FOUND);
  EXPECT_EQ(Relocalize("east", 36, false)->result(), v1::RELOCALIZE_RESULT_FOUND);
}

TEST_F(MapReworkTest, AMapOfOneEyeGetsTheMetresOfTwo) {
  MakeMap("east", 0, kEastEnd, true);
  MakeMap("west", kWestBegin, kWestEnd, false);
  const auto merged = Ask().MergeMaps(WestToEast(), nullptr);
  ASSERT_TRUE(merged.ok()) << merged.status();
  ExpectSound("east");
  // Where only the one eye was.
  ExpectFound("east", 37);
  ExpectFound("east", 5);
}

TEST_F(MapReworkTest, MapsWithoutCommonPlacesStayAsTheyAre) {
  MakeMap("east", 0, kEastEnd);
  MakeMap("west", 0, 20, true, kOtherRoom);
  const std::string east_before = ContentsOf("east");
  const std::string west_before = ContentsOf("west");
  const auto merged = Ask().MergeMaps(WestToEast(), nullptr);
  EXPECT_EQ(client::ErrorReason(merged.status()), "MAPS_DO_NOT_OVERLAP") << merged.status();
  EXPECT_EQ(ContentsOf("east"), east_before);
  EXPECT_EQ(ContentsOf("west"), west_before);
  EXPECT_GE(Drive(v1::SESSION_MODE_EXTEND, "east", 10, 16), 5) << "sessions may begin again";
}

TEST_F(MapReworkTest, ACancelledMergeChangesNothing) {
  MakeBoth();
  const std::string east_before = ContentsOf("east");
  const auto merged = Ask().MergeMaps(WestToEast(), [](const v1::OperationMetadata&) { return false; });
  // It may have been done before the wish arrived.
  if (merged.ok()) GTEST_SKIP() << "the merge was faster";
  EXPECT_TRUE(absl::IsCancelled(merged.status())) << merged.status();
  EXPECT_EQ(ContentsOf("east"), east_before);
  EXPECT_TRUE(Ask().GetMap("west").ok());
  EXPECT_EQ(Ask().ListMaps()->size(), 2U);
}

TEST_F(MapReworkTest, APrunedMapStillTellsPlaces) {
  MakeMap("east", 0, kWestEnd);
  const v1::Map before = *Ask().GetMap("east");
  ASSERT_GE(before.keyframe_count(), 10);
  const std::string contents = ContentsOf("east");
  v1::PruneMapRequest request;
  request.set_name("east");
  request.set_max_keyframes(before.keyframe_count() * 6 / 10);
  request.set_max_points(before.point_count() * 6 / 10);
  request.set_validate_only(true);
  const auto dry = Ask().PruneMap(request, nullptr);
  ASSERT_TRUE(dry.ok()) << dry.status();
  EXPECT_EQ(ContentsOf("east"), contents);
  request.set_validate_only(false);
  const auto pruned = Ask().PruneMap(request, nullptr);
  ASSERT_TRUE(pruned.ok()) << pruned.status();
  EXPECT_EQ(pruned->report.SerializeAsString(), dry->report.SerializeAsString());
  EXPECT_EQ(pruned->map.keyframe_count(), request.max_keyframes());
  EXPECT_LE(pruned->map.point_count(), request.max_points());
  EXPECT_EQ(dry->map.point_count(), pruned->map.point_count());
  EXPECT_EQ(pruned->report.removed_keyframes(), before.keyframe_count() - request.max_keyframes());
  ExpectSound("east");
  for (int picture = 1; picture < kWestEnd; picture += 6) ExpectFound("east", picture);
  // Frames of keyframes that went are where they were.
  for (const double error : TrajectoryErrors("east", 0)) EXPECT_LT(error, kBound);
}

TEST_F(MapReworkTest, AnOptimizedMapIsStraightAgain) {
  MakeMap("east", 0, kEastEnd);
  {
    // Somebody pushes every other keyframe aside.
    const auto store = storage::OpenMapStore(config_.storage);
    ASSERT_TRUE(store.ok()) << store.status();
    const storage::MapInfo map = *(*store)->GetMap("east");
    const auto session = (*store)->StartSession({map.id, "pusher", "nobody", 1, map.rig});
    ASSERT_TRUE(session.ok()) << session.status();
    MapDelta delta;
    delta.version = 1;
    ASSERT_TRUE((*store)
                    ->ForEachKeyFrame(map.id, {},
                                      [&](const storage::KeyFrameEntry& entry) {
                                        if (entry.record.id.value() % 2 == 1) return true;
                                        const SE3 push(Eigen::Quaterniond::Identity(), {0.03, 0.01, 0.02});
                                        delta.moved_keyframes.push_back({entry.record.id,
                                                                         entry.record.map_from_camera * push,
                                                                         entry.record.parent});
                                        return true;
                                      })
                    .ok());
    ASSERT_GE(delta.moved_keyframes.size(), 2U);
    ASSERT_TRUE((*store)->Apply(map.id, session->id, delta).ok());
    ASSERT_TRUE((*store)->EndSession(map.id, session->id, 2, {}).ok());
  }
  const auto optimized = Ask().OptimizeMap("east", 0, nullptr);
  ASSERT_TRUE(optimized.ok()) << optimized.status();
  EXPECT_LT(optimized->report.final_rms_px(), 0.75 * optimized->report.initial_rms_px());
  EXPECT_GT(optimized->report.iterations(), 0);
  for (const double error : TrajectoryErrors("east", 0)) EXPECT_LT(error, kBound);
  ExpectSound("east");
  EXPECT_EQ(client::ErrorReason(Ask().OptimizeMap("east", 5000, nullptr).status()), "FIELD_INVALID");
}

TEST_F(MapReworkTest, AViewerIsToldAnew) {
  MakeMap("east", 0, kEastEnd);
  const int64_t keyframes = Ask().GetMap("east")->keyframe_count();
  v1::PruneMapRequest prune;
  prune.set_name("east");
  prune.set_max_keyframes(keyframes / 2);
  v1::WatchMapRequest request;
  request.set_map("east");
  std::set<uint64_t> shown;
  bool pruned = false;
  const absl::Status status = Ask().WatchMap(request, [&](const v1::WatchMapResponse& response) {
    if (response.reset()) shown.clear();
    for (const v1::KeyFrame& keyframe : response.keyframes()) shown.insert(keyframe.id());
    if (response.map_version() == 0) return true;
    if (std::exchange(pruned, true)) return false;
    EXPECT_EQ(shown.size(), static_cast<size_t>(keyframes));
    EXPECT_TRUE(Ask().PruneMap(prune, nullptr).ok());
    return true;
  });
  EXPECT_TRUE(absl::IsCancelled(status)) << status;
  EXPECT_EQ(shown.size(), static_cast<size_t>(keyframes / 2));
}

}  // namespace
}  // namespace semmap
