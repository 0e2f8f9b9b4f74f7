#include "operation_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

class MapCareTest : public OperationTest {
 protected:
  v1::CheckMapResponse Checked(const absl::StatusOr<v1::Operation>& started) {
    v1::CheckMapResponse response;
    EXPECT_TRUE(Finished(started).response().UnpackTo(&response));
    return response;
  }

  static v1::CheckMapRequest CheckRequest() {
    v1::CheckMapRequest request;
    request.set_name("maps/town");
    return request;
  }
  static v1::RepairMapRequest RepairRequest() {
    v1::RepairMapRequest request;
    request.set_name("maps/town");
    return request;
  }
  static v1::CopyMapRequest CopyRequest(const std::string& new_name) {
    v1::CopyMapRequest request;
    request.set_name("maps/town");
    request.set_new_name("maps/" + new_name);
    request.set_request_id("copy-" + new_name);
    return request;
  }
  static v1::RenameMapRequest RenameRequest(const std::string& new_name) {
    v1::RenameMapRequest request;
    request.set_name("maps/town");
    request.set_new_name("maps/" + new_name);
    return request;
  }
};

TEST_F(MapCareTest, ASoundMapHasNoProblems) {
  MakeMap("town", "s1", 12);
  const v1::CheckMapResponse response = Checked(CheckMap(context_, CheckRequest()));
  EXPECT_EQ(response.problems_size(), 0);
  EXPECT_EQ(response.keyframes(), 3);
  EXPECT_EQ(response.points(), 3);
  EXPECT_EQ(response.observations(), 3);
}

TEST_F(MapCareTest, ProblemsAreCountedAndRepaired) {
  MakeMap("town", "s1", 12);
  const storage::MapId map = store_->GetMap("town")->id;
  const auto session = store_->StartSession({map, "s2", "car", 1, SmallRig()});
  MapDelta delta;
  delta.version = 1;
  delta.removed_points = {MapPointId(1), MapPointId(2)};  // still seen by keyframes
  ASSERT_TRUE(store_->Apply(map, session->id, delta).ok());
  const v1::CheckMapResponse broken = Checked(CheckMap(context_, CheckRequest()));
  ASSERT_EQ(broken.problems_size(), 1);
  EXPECT_EQ(broken.problems(0).check(), "dangling-observation");
  EXPECT_EQ(broken.problems(0).count(), 2);
  EXPECT_FALSE(broken.problems(0).detail().empty());
  const v1::CheckMapResponse repaired = Checked(RepairMap(context_, RepairRequest()));
  EXPECT_EQ(repaired.problems_size(), 0);
  EXPECT_EQ(repaired.points(), 1);
}

TEST_F(MapCareTest, CopyIsAnotherMap) {
  MakeMap("town", "s1", 12);
  v1::Map copy;
  const auto started = CopyMap(context_, CopyRequest("copy"));
  EXPECT_TRUE(Finished(started).response().UnpackTo(&copy));
  EXPECT_EQ(copy.name(), "maps/copy");
  EXPECT_EQ(copy.keyframe_count(), 3);
  // Sent again, the request answers the same operation.
  EXPECT_EQ(CopyMap(context_, CopyRequest("copy"))->name(), started->name());
  v1::CopyMapRequest again = CopyRequest("copy");
  again.set_request_id("another");
  EXPECT_EQ(ReasonOf(CopyMap(context_, again).status()), v1::ERROR_REASON_MAP_EXISTS);
}

TEST_F(MapCareTest, RenamedMapsKeepTheirContents) {
  MakeMap("town", "s1", 12);
  const auto renamed = RenameMap(context_, RenameRequest("village"));
  ASSERT_TRUE(renamed.ok()) << renamed.status();
  EXPECT_EQ(renamed->name(), "maps/village");
  EXPECT_EQ(renamed->keyframe_count(), 3);
  EXPECT_TRUE(renamed->has_update_time());
  EXPECT_EQ(ReasonOf(RenameMap(context_, RenameRequest("x")).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
  MakeMap("town", "s2", 1);
  EXPECT_EQ(ReasonOf(RenameMap(context_, RenameRequest("village")).status()), v1::ERROR_REASON_MAP_EXISTS);
  EXPECT_EQ(ReasonOf(RenameMap(context_, RenameRequest("no name")).status()), v1::ERROR_REASON_NAME_INVALID);
}

TEST_F(MapCareTest, AMapInUseIsLeftAlone) {
  ASSERT_NE(OpenSession("town"), nullptr);
  EXPECT_EQ(ReasonOf(RenameMap(context_, RenameRequest("x")).status()), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_EQ(ReasonOf(CopyMap(context_, CopyRequest("x")).status()), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_EQ(ReasonOf(RepairMap(context_, RepairRequest()).status()), v1::ERROR_REASON_MAP_IN_USE);
  EXPECT_TRUE(Finished(CheckMap(context_, CheckRequest())).has_response());
}

TEST_F(MapCareTest, MapsThatAreNotThere) {
  EXPECT_EQ(ReasonOf(CheckMap(context_, CheckRequest()).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
  EXPECT_EQ(ReasonOf(RepairMap(context_, RepairRequest()).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
  EXPECT_EQ(ReasonOf(CopyMap(context_, CopyRequest("x")).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
}

TEST_F(MapCareTest, OperationsAreListedInPages) {
  MakeMap("town", "s1", 1);
  for (int i = 0; i < 3; ++i) Finished(CheckMap(context_, CheckRequest()));
  v1::ListOperationsRequest request;
  request.set_page_size(2);
  const auto first = ListOperations(context_, request);
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_EQ(first->operations_size(), 2);
  EXPECT_EQ(first->operations(0).name(), "operations/3");
  request.set_page_token(first->next_page_token());
  const auto second = ListOperations(context_, request);
  ASSERT_EQ(second->operations_size(), 1);
  EXPECT_EQ(second->operations(0).name(), "operations/1");
  EXPECT_TRUE(second->next_page_token().empty());
}

TEST_F(MapCareTest, WaitingHasAnEnd) {
  v1::WaitOperationRequest request;
  absl::Status status;
  const auto note = [&](const absl::StatusOr<v1::Operation>& operation) { status = operation.status(); };
  request.set_name("operations/1");
  WaitOperation(context_, request, note);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_OPERATION_NOT_FOUND);
  request.mutable_timeout()->set_seconds(-1);
  WaitOperation(context_, request, note);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_FIELD_INVALID);

  Notification release;
  ASSERT_TRUE(
      operations_
          .Start(v1::OPERATION_KIND_CHECK, {"town"},
                 [&](OperationProgress&) -> absl::StatusOr<std::unique_ptr<google::protobuf::Message>> {
                   release.WaitForNotification();
                   return absl::UnknownError("");
                 })
          .ok());
  request.mutable_timeout()->set_seconds(0);
  request.mutable_timeout()->set_nanos(10'000'000);
  Notification answered;
  WaitOperation(context_, request, [&](const absl::StatusOr<v1::Operation>& operation) {
    EXPECT_FALSE(operation->done());
    answered.Notify();
  });
  EXPECT_TRUE(answered.WaitForNotificationWithTimeout(absl::Seconds(10)));
  release.Notify();
}

}  // namespace
}  // namespace semmap::server
