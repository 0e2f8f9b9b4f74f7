#include <set>
#include <utility>

#include "client/client.h"
#include "client/errors.h"
#include "service_fixture.h"

// WatchMap over the wire, while a vehicle drives.
namespace semmap {
namespace {

using WatchServiceTest = ServiceTest;

TEST_F(WatchServiceTest, AViewerSeesWhatAVehicleAdds) {
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (uint64_t sequence = 1; sequence <= 12; ++sequence) ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
  client::Client client(Connect());
  v1::WatchMapRequest request;
  request.set_map("town");
  std::set<uint64_t> points;
  bool more_sent = false;
  const absl::Status status = client.WatchMap(request, [&](const v1::WatchMapResponse& response) {
    if (response.reset()) points.clear();
    points.insert(response.points().ids().begin(), response.points().ids().end());
    // From now on only changes come.
    if (!more_sent && response.map_version() > 0) {
      more_sent = true;
      for (uint64_t sequence = 13; sequence <= 50; ++sequence) {
        EXPECT_TRUE((*drive)->Send(Frame(sequence)).ok());
      }
    }
    return points.size() < 10;
  });
  EXPECT_TRUE(absl::IsCancelled(status)) << status;
  EXPECT_EQ(points.size(), 10U);
  EXPECT_TRUE((*drive)->Finish().ok());
}

TEST_F(WatchServiceTest, DeletingTheMapEndsIt) {
  client::Client client(Connect());
  v1::Map map;
  map.set_name("town");
  ASSERT_TRUE(client.CreateMap(map).ok());
  v1::WatchMapRequest request;
  request.set_map("town");
  bool deleted = false;
  const absl::Status status = client.WatchMap(request, [&](const v1::WatchMapResponse&) {
    if (!std::exchange(deleted, true)) {
      EXPECT_TRUE(client::Client(Connect()).DeleteMap("town").ok());
    }
    return true;
  });
  EXPECT_TRUE(deleted);
  EXPECT_EQ(client::ErrorReason(status), "MAP_NOT_FOUND");
}

}  // namespace
}  // namespace semmap
