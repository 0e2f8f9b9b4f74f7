#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include "client/grpc_status.h"
#include "semmap/v1/map_service.grpc.pb.h"
#include "service_fixture.h"

namespace semmap {
namespace {

// One call of any kind with an empty first message.
struct Outcome {
  absl::Status status;
  std::string response;
};

class ContractTest : public ServiceTest {
 protected:
  Outcome Call(const std::string& path) {
    grpc::GenericStub stub(Connect()->channel());
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
    grpc::CompletionQueue queue;
    // A message without fields; a buffer without a slice would be no message at all.
    const grpc::Slice nothing;
    const grpc::ByteBuffer empty(&nothing, 1);
    auto call = stub.PrepareUnaryCall(&context, path, empty, &queue);
    call->StartCall();
    grpc::ByteBuffer response;
    grpc::Status status;
    call->Finish(&response, &status, nullptr);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    grpc::Slice slice;
    if (status.ok() && response.Valid()) response.DumpToSingleSlice(&slice);
    return {client::FromGrpc(status),
            std::string(reinterpret_cast<const char*>(slice.begin()), slice.size())};
  }
};

// Every call of the contract is answered by the service itself: by success, or by a status with a reason.
TEST_F(ContractTest, EveryCallIsKnown) {
  const auto* pool = google::protobuf::DescriptorPool::generated_pool();
  int calls = 0;
  for (const char* name : {"semmap.v1.MapService", "semmap.v1.LocalizationService",
                           "semmap.v1.OperationService", "semmap.v1.SessionService"}) {
    const auto* service = pool->FindServiceByName(name);
    ASSERT_NE(service, nullptr) << name;
    for (int i = 0; i < service->method_count(); ++i) {
      const std::string path = std::string("/") + name + "/" + service->method(i)->name();
      const absl::Status status = Call(path).status;
      EXPECT_TRUE(status.ok() || !client::ErrorReason(status).empty()) << path << ": " << status;
      ++calls;
    }
  }
  EXPECT_EQ(calls, 30);
}

TEST_F(ContractTest, HealthFollowsTheDrain) {
  // grpc.health.v1.HealthCheckResponse.status: 1 SERVING, 2 NOT_SERVING.
  EXPECT_EQ(Call("/grpc.health.v1.Health/Check").response, std::string("\x08\x01"));
  gate_.Close();
  auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_TRUE((*drive)->Send(Frame(1)).ok());
  ASSERT_TRUE(gate_.WaitForFrames(1));
  const auto connection = Connect();
  std::thread stop([&] { server_->Drain(); });
  std::string health;
  const absl::Time deadline = absl::Now() + absl::Seconds(10);
  while (health != "\x08\x02" && absl::Now() < deadline)
    health = Call("/grpc.health.v1.Health/Check").response;
  EXPECT_EQ(health, std::string("\x08\x02"));
  auto refused = client::Drive::Start(Connect(), DriveTo("other"), {});
  EXPECT_EQ(client::ErrorReason(refused.status()), "SHUTTING_DOWN");
  gate_.Open();
  stop.join();
}

TEST_F(ContractTest, ReflectionIsThereWhenConfigured) {
  const absl::Status status = Call("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo").status;
  EXPECT_NE(status.code(), absl::StatusCode::kUnimplemented) << status;
}

TEST_F(ContractTest, MapsThroughTheClientLibrary) {
  client::Client client(Connect());
  v1::Map map;
  map.set_name("town");
  const auto created = client.CreateMap(map);
  ASSERT_TRUE(created.ok()) << created.status();
  EXPECT_EQ(created->name(), "maps/town");
  EXPECT_EQ(client::ErrorReason(client.CreateMap(map).status()), "MAP_EXISTS");
  EXPECT_TRUE(client.GetMap("town").ok());
  EXPECT_EQ(client.GetMapSummary("town")->frame_count(), 0);
  EXPECT_TRUE(client.DeleteMap("town").ok());
  EXPECT_EQ(client::ErrorReason(client.GetMap("town").status()), "MAP_NOT_FOUND");
  v1::QueryMapPointsRequest request;
  request.set_map("town");
  const auto all = [](const auto&) { return true; };
  EXPECT_EQ(client::ErrorReason(client.QueryMapPoints(request, all)), "MAP_NOT_FOUND");
}

}  // namespace
}  // namespace semmap
