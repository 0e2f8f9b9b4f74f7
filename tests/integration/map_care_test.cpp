#include "client/client.h"
#include "client/errors.h"
#include "service_fixture.h"

// Renaming, copying, checking and repairing maps over the wire, with operations that are waited for.
namespace semmap {
namespace {

class MapCareServiceTest : public ServiceTest {
 protected:
  void MakeTown() {
    auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
    ASSERT_TRUE(drive.ok()) << drive.status();
    for (uint64_t sequence = 1; sequence <= 12; ++sequence) ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
    ASSERT_TRUE((*drive)->Finish().ok());
  }
};

TEST_F(MapCareServiceTest, CopyCheckRenameRepair) {
  MakeTown();
  client::Client client(Connect());
  int reports = 0;
  const auto copy = client.CopyMap("town", "copy", [&](const v1::OperationMetadata& metadata) {
    EXPECT_EQ(metadata.kind(), v1::OPERATION_KIND_COPY);
    ++reports;
    return true;
  });
  ASSERT_TRUE(copy.ok()) << copy.status();
  EXPECT_GE(reports, 1);
  EXPECT_EQ(copy->keyframe_count(), client.GetMap("town")->keyframe_count());
  EXPECT_TRUE(copy->has_update_time());
  const auto renamed = client.RenameMap("copy", "village");
  ASSERT_TRUE(renamed.ok()) << renamed.status();
  EXPECT_EQ(renamed->name(), "maps/village");
  const auto checked = client.CheckMap("village", nullptr);
  ASSERT_TRUE(checked.ok()) << checked.status();
  EXPECT_EQ(checked->problems_size(), 0);
  EXPECT_EQ(checked->keyframes(), copy->keyframe_count());
  const auto repaired = client.RepairMap("village", nullptr);
  ASSERT_TRUE(repaired.ok()) << repaired.status();
  EXPECT_EQ(repaired->problems_size(), 0);
}

TEST_F(MapCareServiceTest, FailuresCarryTheirReasons) {
  MakeTown();
  client::Client client(Connect());
  EXPECT_EQ(client::ErrorReason(client.CopyMap("town", "town", nullptr).status()), "MAP_EXISTS");
  EXPECT_EQ(client::ErrorReason(client.CheckMap("nowhere", nullptr).status()), "MAP_NOT_FOUND");
  EXPECT_EQ(client::ErrorReason(client.RenameMap("town", "town").status()), "");
  const auto cancelled = client.CopyMap("town", "copy", [](const v1::OperationMetadata&) { return false; });
  // It may have been done before the wish arrived.
  EXPECT_TRUE(cancelled.ok() || absl::IsCancelled(cancelled.status())) << cancelled.status();
}

}  // namespace
}  // namespace semmap
