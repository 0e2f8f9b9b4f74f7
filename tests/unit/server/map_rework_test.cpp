// What merging, optimizing and pruning refuse, and how they keep sessions off. That they do what they should
// is for tests with real SLAM (tests/integration/map_rework_test.cpp).
#include "google/rpc/error_details.pb.h"
#include "operation_fixture.h"
#include "server/handlers/map_handlers.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap::server {
namespace {

class MapReworkTest : public OperationTest {
 protected:
  MapReworkTest() { context_.vocabulary = testing::RandomVocabulary(4, 1); }

  static v1::MergeMapsRequest MergeRequest(const std::string& target, const std::string& source) {
    v1::MergeMapsRequest request;
    request.set_target("maps/" + target);
    request.set_source("maps/" + source);
    return request;
  }
  static v1::PruneMapRequest PruneRequest(int64_t max_keyframes, int64_t max_points) {
    v1::PruneMapRequest request;
    request.set_name("maps/town");
    request.set_max_keyframes(max_keyframes);
    request.set_max_points(max_points);
    return request;
  }
  v1::ErrorReason ReasonOfMerge(const v1::MergeMapsRequest& request) {
    return ReasonOf(MergeMaps(context_, request).status());
  }
  // The reason that a finished operation failed for.
  static std::string ReasonOfError(const v1::Operation& operation) {
    google::rpc::ErrorInfo info;
    if (operation.error().details_size() > 0) info.ParseFromString(operation.error().details(0).value());
    return info.reason();
  }
};

TEST_F(MapReworkTest, MergesThatCannotBeAreRefusedAtOnce) {
  EXPECT_EQ(ReasonOfMerge(MergeRequest("town", "village")), v1::ERROR_REASON_MAP_NOT_FOUND);
  MakeMap("town", "s1", 12);
  EXPECT_EQ(ReasonOfMerge(MergeRequest("town", "village")), v1::ERROR_REASON_MAP_NOT_FOUND);
  EXPECT_EQ(ReasonOfMerge(MergeRequest("town", "town")), v1::ERROR_REASON_FIELD_INVALID);
  EXPECT_EQ(ReasonOfMerge(MergeRequest("no name", "town")), v1::ERROR_REASON_NAME_INVALID);
  ASSERT_TRUE(store_->CreateMap({"village", 1, SmallRig(), false}).ok());
  EXPECT_EQ(ReasonOfMerge(MergeRequest("town", "village")), v1::ERROR_REASON_MAP_EMPTY);
  EXPECT_EQ(ReasonOfMerge(MergeRequest("village", "town")), v1::ERROR_REASON_MAP_EMPTY);
}

TEST_F(MapReworkTest, MapsOfOtherCamerasAreNotJoined) {
  MakeMap("town", "s1", 12);
  CameraRig wide = SmallRig();
  wide.camera.fx = 40;
  const auto map = store_->CreateMap({"village", 1, wide, false});
  ASSERT_TRUE(map.ok());
  const auto session = store_->StartSession({map->id, "s2", "car", 1, wide});
  StoringSink sink(store_.get(), map->id, session->id);
  FakeSession slam(&sink, nullptr);
  FrameInput frame;
  frame.sequence = 1;
  ASSERT_TRUE(slam.Track(frame).ok());
  slam.Finish();
  EXPECT_EQ(ReasonOfMerge(MergeRequest("town", "village")), v1::ERROR_REASON_MAPS_DIFFER_IN_CAMERAS);
}

TEST_F(MapReworkTest, WithoutAVocabularyNothingIsMerged) {
  MakeMap("town", "s1", 12);
  MakeMap("village", "s2", 12);
  context_.vocabulary = nullptr;
  EXPECT_EQ(ReasonOfMerge(MergeRequest("town", "village")), v1::ERROR_REASON_NOT_IMPLEMENTED);
}

TEST_F(MapReworkTest, NothingInCommonSaysWhatWasFoundAndLetsGo) {
  MakeMap("town", "s1", 12);
  MakeMap("village", "s2", 12);
  const v1::Operation operation = Finished(MergeMaps(context_, MergeRequest("town", "village")));
  EXPECT_EQ(ReasonOfError(operation), "MAPS_DO_NOT_OVERLAP");
  EXPECT_NE(operation.error().message().find("of the 3 keyframes"), std::string::npos)
      << operation.error().message();
  EXPECT_EQ(operation.metadata().kind(), v1::OPERATION_KIND_MERGE);
  EXPECT_EQ(operation.metadata().maps_size(), 2);
  EXPECT_FALSE(sessions_->IsMapInUse("town"));
  EXPECT_FALSE(sessions_->IsMapInUse("village"));
  EXPECT_EQ(store_->ListMaps({})->size(), 2U);
}

TEST_F(MapReworkTest, AMapInUseIsLeftAlone) {
  MakeMap("village", "s2", 12);
  ASSERT_NE(OpenSession("town"), nullptr);
  EXPECT_EQ(ReasonOfMerge(MergeRequest("town", "village")), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_EQ(ReasonOfMerge(MergeRequest("village", "town")), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_EQ(ReasonOf(PruneMap(context_, PruneRequest(1, 0)).status()), v1::ERROR_REASON_MAP_IN_USE);
}

TEST_F(MapReworkTest, AHoldKeepsSessionsAndOtherOperationsOff) {
  MakeMap("village", "s2", 12);
  auto hold = sessions_->Hold({"town", "village"});
  ASSERT_TRUE(hold.ok()) << hold.status();
  v1::SessionHello hello;
  hello.set_vehicle_id("car");
  hello.set_map("maps/town");
  hello.set_mode(v1::SESSION_MODE_MAP);
  v1::CameraRig& rig = *hello.mutable_rig();
  rig.set_sensor(v1::SENSOR_TYPE_MONO);
  rig.mutable_camera()->set_width(64);
  rig.mutable_camera()->set_height(48);
  rig.mutable_camera()->set_fx(50);
  rig.mutable_camera()->set_fy(50);
  rig.mutable_camera()->set_cx(32);
  rig.mutable_camera()->set_cy(24);
  rig.mutable_camera()->set_distortion_model(v1::DISTORTION_MODEL_NONE);
  EXPECT_EQ(ReasonOf(sessions_->Open(hello).status()), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_EQ(ReasonOf(sessions_->Hold({"market", "village"}).status()), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_FALSE(sessions_->IsMapInUse("market")) << "all or none";
  v1::DeleteMapRequest remove;
  remove.set_name("maps/village");
  EXPECT_EQ(ReasonOf(DeleteMap(context_, remove).status()), v1::ERROR_REASON_MAP_IN_USE);
  hold->reset();
  EXPECT_TRUE(sessions_->Open(hello).ok());
  EXPECT_TRUE(DeleteMap(context_, remove).ok());
}

TEST_F(MapReworkTest, PruneKeepsABudget) {
  MakeMap("town", "s1", 22);
  const storage::MapInfo before = *store_->GetMap("town");
  ASSERT_EQ(before.keyframe_count, 5U);
  EXPECT_EQ(ReasonOf(PruneMap(context_, PruneRequest(0, 0)).status()), v1::ERROR_REASON_FIELD_INVALID);
  EXPECT_EQ(ReasonOf(PruneMap(context_, PruneRequest(-1, 3)).status()), v1::ERROR_REASON_FIELD_INVALID);
  v1::PruneMapRequest request = PruneRequest(3, 0);
  request.set_validate_only(true);
  v1::Map counted;
  const v1::Operation dry = Finished(PruneMap(context_, request));
  ASSERT_TRUE(dry.response().UnpackTo(&counted)) << dry.error().message();
  EXPECT_EQ(counted.keyframe_count(), 3);
  EXPECT_EQ(dry.metadata().prune().removed_keyframes(), 2);
  EXPECT_EQ(store_->GetMap("town")->version, before.version);
  request.set_validate_only(false);
  v1::Map pruned;
  ASSERT_TRUE(Finished(PruneMap(context_, request)).response().UnpackTo(&pruned));
  EXPECT_EQ(pruned.keyframe_count(), 3);
  EXPECT_EQ(pruned.point_count(), counted.point_count());
  const storage::MapInfo after = *store_->GetMap("town");
  EXPECT_EQ(after.keyframe_count, 3U);
  EXPECT_GT(after.version, before.version);
  EXPECT_TRUE(store_->CheckIntegrity(after.id, 10)->empty());
  // What is within the budget is left as it is.
  ASSERT_TRUE(Finished(PruneMap(context_, PruneRequest(3, 100))).response().UnpackTo(&pruned));
  EXPECT_EQ(store_->GetMap("town")->version, after.version);
}

TEST_F(MapReworkTest, OptimizeHasBounds) {
  MakeMap("town", "s1", 12);
  v1::OptimizeMapRequest request;
  request.set_name("maps/town");
  for (const int iterations : {-1, 1001}) {
    request.set_max_iterations(iterations);
    EXPECT_EQ(ReasonOf(OptimizeMap(context_, request).status()), v1::ERROR_REASON_FIELD_INVALID);
  }
  request.set_max_iterations(3);
  request.set_request_id("once");
  const auto started = OptimizeMap(context_, request);
  const v1::Operation done = Finished(started);
  EXPECT_TRUE(done.has_response()) << done.error().message();
  EXPECT_TRUE(done.metadata().has_optimize());
  EXPECT_LE(done.metadata().optimize().iterations(), 3);
  EXPECT_FALSE(done.metadata().stage().empty());
  EXPECT_EQ(OptimizeMap(context_, request)->name(), started->name()) << "sent again";
  ASSERT_TRUE(store_->CreateMap({"village", 1, SmallRig(), false}).ok());
  request.set_name("maps/village");
  request.set_request_id("");
  EXPECT_EQ(ReasonOf(OptimizeMap(context_, request).status()), v1::ERROR_REASON_MAP_EMPTY);
}

TEST_F(MapReworkTest, MapsBeyondTheMemoryLimitAreRefused) {
  MakeMap("town", "s1", 12);
  context_.config.map_memory_mb = 0;
  const v1::Operation operation = Finished(PruneMap(context_, PruneRequest(1, 0)));
  EXPECT_EQ(ReasonOfError(operation), "MAP_TOO_LARGE");
  EXPECT_FALSE(sessions_->IsMapInUse("town"));
}

}  // namespace
}  // namespace semmap::server
