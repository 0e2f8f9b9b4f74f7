#include "client/client.h"

#include <chrono>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "client/grpc_status.h"
#include "client/message_reader.h"
#include "client/message_writer.h"
#include "client/names.h"
#include "client/request_id.h"
#include "semmap/v1/localization_service.grpc.pb.h"
#include "semmap/v1/map_service.grpc.pb.h"
#include "semmap/v1/operation.grpc.pb.h"
#include "semmap/v1/session_service.grpc.pb.h"

namespace semmap::client {
namespace {

void SetDeadline(const Connection& connection, grpc::ClientContext* context) {
  context->set_deadline(std::chrono::system_clock::now() + connection.options().call_timeout);
}

// One unary call: `call` is a stub's method.
template <typename Response, typename Stub, typename Request>
absl::StatusOr<Response> CallUnary(const Connection& connection, Stub& stub,
                                   grpc::Status (Stub::*call)(grpc::ClientContext*, const Request&,
                                                              Response*),
                                   const Request& request) {
  grpc::ClientContext context;
  SetDeadline(connection, &context);
  Response response;
  const grpc::Status status = (stub.*call)(&context, request, &response);
  if (!status.ok()) return FromGrpc(status);
  return response;
}

template <typename Response>
absl::Status ReadAll(MessageReader<Response>& reader, std::chrono::milliseconds timeout,
                     const Client::Consumer<Response>& consumer) {
  reader.Begin();
  while (const Response* response = reader.Next(timeout)) {
    if (!consumer(*response)) return reader.Finish(true);
  }
  return reader.Finish(false);
}

// Sends the header that `request` holds, then what `read` gives. Fails only with `read`'s status: what the
// server says is told when the call is finished.
template <typename Writer>
absl::Status SendAll(Writer& writer, v1::ImportMapRequest* request,
                     const std::function<absl::StatusOr<size_t>(std::span<char>)>& read,
                     std::chrono::milliseconds timeout) {
  constexpr size_t kChunk = 256 << 10;
  writer.Begin();
  while (writer.Write(*request, timeout)) {
    std::string& chunk = *request->mutable_chunk();
    chunk.resize(kChunk);
    const auto size = read(std::span<char>(chunk));
    if (!size.ok()) return size.status();
    if (*size == 0) return absl::OkStatus();
    chunk.resize(*size);
  }
  return absl::OkStatus();
}

// How often progress is told; the end of an operation is answered at once.
constexpr std::chrono::milliseconds kPollInterval(500);

google::protobuf::Duration ToDuration(std::chrono::milliseconds duration) {
  google::protobuf::Duration result;
  result.set_seconds(duration / std::chrono::seconds(1));
  result.set_nanos(
      static_cast<int32_t>(std::chrono::nanoseconds(duration % std::chrono::seconds(1)).count()));
  return result;
}

absl::Status Stopped() { return absl::CancelledError("the caller wanted no more"); }

}  // namespace

struct Client::Stubs {
  explicit Stubs(const std::shared_ptr<grpc::Channel>& channel)
      : maps(channel), sessions(channel), operations(channel), localization(channel) {}
  v1::MapService::Stub maps;
  v1::SessionService::Stub sessions;
  v1::OperationService::Stub operations;
  v1::LocalizationService::Stub localization;
};

Client::Client(std::shared_ptr<Connection> connection)
    : connection_(std::move(connection)), stubs_(std::make_unique<Stubs>(connection_->channel())) {}

Client::~Client() = default;

absl::StatusOr<v1::Map> Client::CreateMap(const v1::Map& map) {
  v1::CreateMapRequest request;
  *request.mutable_map() = map;
  request.mutable_map()->set_name(MapName(map.name()));
  request.set_request_id(NewRequestId());
  return CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::CreateMap, request);
}

absl::StatusOr<v1::Map> Client::GetMap(const std::string& map) {
  v1::GetMapRequest request;
  request.set_name(MapName(map));
  return CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::GetMap, request);
}

absl::StatusOr<std::vector<v1::Map>> Client::ListMaps() {
  std::vector<v1::Map> maps;
  v1::ListMapsRequest request;
  do {
    auto response = CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::ListMaps, request);
    if (!response.ok()) return response.status();
    maps.insert(maps.end(), response->maps().begin(), response->maps().end());
    request.set_page_token(response->next_page_token());
  } while (!request.page_token().empty());
  return maps;
}

absl::StatusOr<v1::Map> Client::UpdateMap(const v1::Map& map, const std::vector<std::string>& paths) {
  v1::UpdateMapRequest request;
  *request.mutable_map() = map;
  request.mutable_map()->set_name(MapName(map.name()));
  for (const std::string& path : paths) request.mutable_update_mask()->add_paths(path);
  request.set_request_id(NewRequestId());
  return CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::UpdateMap, request);
}

absl::Status Client::DeleteMap(const std::string& map) {
  v1::DeleteMapRequest request;
  request.set_name(MapName(map));
  request.set_request_id(NewRequestId());
  return CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::DeleteMap, request).status();
}

absl::StatusOr<v1::Map> Client::RenameMap(const std::string& map, const std::string& new_name) {
  v1::RenameMapRequest request;
  request.set_name(MapName(map));
  request.set_new_name(MapName(new_name));
  request.set_request_id(NewRequestId());
  return CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::RenameMap, request);
}

absl::StatusOr<v1::Operation> Client::Await(absl::StatusOr<v1::Operation> operation,
                                            const Progress& progress) {
  bool cancelled = false;
  while (operation.ok() && !operation->done()) {
    if (!cancelled && progress && !progress(operation->metadata())) {
      cancelled = true;
      v1::CancelOperationRequest cancel;
      cancel.set_name(operation->name());
      const auto answer =
          CallUnary(*connection_, stubs_->operations, &v1::OperationService::Stub::CancelOperation, cancel);
      if (!answer.ok()) return answer.status();
    }
    v1::WaitOperationRequest wait;
    wait.set_name(operation->name());
    *wait.mutable_timeout() = ToDuration(kPollInterval);
    operation = CallUnary(*connection_, stubs_->operations, &v1::OperationService::Stub::WaitOperation, wait);
  }
  return operation;
}

template <typename Response>
absl::StatusOr<Response> Client::Finish(absl::StatusOr<v1::Operation> operation, const Progress& progress,
                                        v1::Operation* done) {
  operation = Await(std::move(operation), progress);
  if (!operation.ok()) return operation.status();
  if (operation->has_error()) return FromRpcStatus(operation->error());
  if (done != nullptr) *done = *operation;
  Response response;
  if (operation->response().UnpackTo(&response)) return response;
  return absl::InternalError("the server answered an operation with a message of another kind");
}

absl::StatusOr<v1::Map> Client::CopyMap(const std::string& map, const std::string& new_name,
                                        const Progress& progress) {
  v1::CopyMapRequest request;
  request.set_name(MapName(map));
  request.set_new_name(MapName(new_name));
  request.set_request_id(NewRequestId());
  return Finish<v1::Map>(CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::CopyMap, request),
                         progress);
}

absl::StatusOr<v1::CheckMapResponse> Client::CheckMap(const std::string& map, const Progress& progress) {
  v1::CheckMapRequest request;
  request.set_name(MapName(map));
  return Finish<v1::CheckMapResponse>(
      CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::CheckMap, request), progress);
}

absl::StatusOr<v1::CheckMapResponse> Client::RepairMap(const std::string& map, const Progress& progress) {
  v1::RepairMapRequest request;
  request.set_name(MapName(map));
  request.set_request_id(NewRequestId());
  return Finish<v1::CheckMapResponse>(
      CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::RepairMap, request), progress);
}

absl::StatusOr<v1::MergeMapsResponse> Client::MergeMaps(v1::MergeMapsRequest request,
                                                        const Progress& progress) {
  request.set_target(MapName(request.target()));
  request.set_source(MapName(request.source()));
  request.set_request_id(NewRequestId());
  return Finish<v1::MergeMapsResponse>(
      CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::MergeMaps, request), progress);
}

absl::StatusOr<Client::Optimized> Client::OptimizeMap(const std::string& map, int max_iterations,
                                                      const Progress& progress) {
  v1::OptimizeMapRequest request;
  request.set_name(MapName(map));
  request.set_max_iterations(max_iterations);
  request.set_request_id(NewRequestId());
  v1::Operation done;
  auto optimized = Finish<v1::Map>(
      CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::OptimizeMap, request), progress, &done);
  if (!optimized.ok()) return optimized.status();
  return Optimized{*std::move(optimized), done.metadata().optimize()};
}

absl::StatusOr<Client::Pruned> Client::PruneMap(v1::PruneMapRequest request, const Progress& progress) {
  request.set_name(MapName(request.name()));
  request.set_request_id(NewRequestId());
  v1::Operation done;
  auto pruned = Finish<v1::Map>(
      CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::PruneMap, request), progress, &done);
  if (!pruned.ok()) return pruned.status();
  return Pruned{*std::move(pruned), done.metadata().prune()};
}

absl::StatusOr<v1::Map> Client::ImportMap(const std::string& map, const std::string& sha256,
                                          const std::function<absl::StatusOr<size_t>(std::span<char>)>& read,
                                          const Progress& progress) {
  v1::ImportMapRequest request;
  request.mutable_header()->set_name(MapName(map));
  request.mutable_header()->set_format(v1::MAP_FILE_FORMAT_SEMMAP);
  request.mutable_header()->set_sha256(sha256);
  request.mutable_header()->set_request_id(NewRequestId());
  MessageWriter<v1::ImportMapRequest, v1::Operation> writer;
  stubs_->maps.async()->ImportMap(writer.context(), writer.response(), &writer);
  const absl::Status sent = SendAll(writer, &request, read, connection_->options().call_timeout);
  absl::Status finished = writer.Finish(!sent.ok(), connection_->options().call_timeout);
  if (!sent.ok()) return sent;
  if (!finished.ok()) return finished;
  return Finish<v1::Map>(*writer.response(), progress);
}

absl::StatusOr<Client::Export> Client::ExportMap(v1::ExportMapRequest request, const Progress& progress) {
  request.set_name(MapName(request.name()));
  request.set_request_id(NewRequestId());
  v1::Operation done;
  auto file = Finish<v1::ExportMapResponse>(
      CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::ExportMap, request), progress, &done);
  if (!file.ok()) return file.status();
  return Export{*std::move(file), done.name()};
}

absl::Status Client::ReadArtifact(const std::string& artifact, int64_t offset,
                                  const Consumer<v1::ReadArtifactResponse>& consumer) {
  v1::ReadArtifactRequest request;
  request.set_name(artifact);
  request.set_offset(offset);
  MessageReader<v1::ReadArtifactResponse> reader;
  stubs_->maps.async()->ReadArtifact(reader.context(), &request, &reader);
  return ReadAll(reader, connection_->options().call_timeout, consumer);
}

absl::Status Client::DeleteOperation(const std::string& operation) {
  v1::DeleteOperationRequest request;
  request.set_name(operation);
  return CallUnary(*connection_, stubs_->operations, &v1::OperationService::Stub::DeleteOperation, request)
      .status();
}

absl::StatusOr<v1::MapSummary> Client::GetMapSummary(const std::string& map) {
  v1::GetMapSummaryRequest request;
  request.set_name(MapName(map));
  return CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::GetMapSummary, request);
}

absl::Status Client::QueryMapPoints(v1::QueryMapPointsRequest request,
                                    const Consumer<v1::QueryMapPointsResponse>& consumer) {
  request.set_map(MapName(request.map()));
  MessageReader<v1::QueryMapPointsResponse> reader;
  stubs_->maps.async()->QueryMapPoints(reader.context(), &request, &reader);
  return ReadAll(reader, connection_->options().call_timeout, consumer);
}

absl::Status Client::QueryKeyFrames(v1::QueryKeyFramesRequest request,
                                    const Consumer<v1::KeyFrame>& consumer) {
  request.set_map(MapName(request.map()));
  if (!request.session().empty()) request.set_session(SessionName(request.session()));
  request.clear_page_token();
  do {
    auto response = CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::QueryKeyFrames, request);
    if (!response.ok()) return response.status();
    for (const v1::KeyFrame& keyframe : response->keyframes()) {
      if (!consumer(keyframe)) return Stopped();
    }
    request.set_page_token(response->next_page_token());
  } while (!request.page_token().empty());
  return absl::OkStatus();
}

absl::Status Client::GetTrajectory(v1::GetTrajectoryRequest request,
                                   const Consumer<v1::GetTrajectoryResponse>& consumer) {
  request.set_map(MapName(request.map()));
  if (!request.session().empty()) request.set_session(SessionName(request.session()));
  MessageReader<v1::GetTrajectoryResponse> reader;
  stubs_->maps.async()->GetTrajectory(reader.context(), &request, &reader);
  return ReadAll(reader, connection_->options().call_timeout, consumer);
}

absl::StatusOr<v1::RelocalizeResponse> Client::Relocalize(v1::RelocalizeRequest request) {
  request.set_map(MapName(request.map()));
  return CallUnary(*connection_, stubs_->localization, &v1::LocalizationService::Stub::Relocalize, request);
}

absl::Status Client::WatchMap(v1::WatchMapRequest request, const Consumer<v1::WatchMapResponse>& consumer) {
  // Nothing may change for long.
  constexpr std::chrono::milliseconds kPatience = std::chrono::hours(24 * 365);
  request.set_map(MapName(request.map()));
  MessageReader<v1::WatchMapResponse> reader;
  stubs_->maps.async()->WatchMap(reader.context(), &request, &reader);
  return ReadAll(reader, kPatience, consumer);
}

absl::StatusOr<v1::Session> Client::GetSession(const std::string& session) {
  v1::GetSessionRequest request;
  request.set_name(SessionName(session));
  return CallUnary(*connection_, stubs_->sessions, &v1::SessionService::Stub::GetSession, request);
}

absl::StatusOr<std::vector<v1::Session>> Client::ListSessions(v1::ListSessionsRequest request) {
  std::vector<v1::Session> sessions;
  if (!request.map().empty()) request.set_map(MapName(request.map()));
  request.clear_page_token();
  do {
    auto response =
        CallUnary(*connection_, stubs_->sessions, &v1::SessionService::Stub::ListSessions, request);
    if (!response.ok()) return response.status();
    sessions.insert(sessions.end(), response->sessions().begin(), response->sessions().end());
    request.set_page_token(response->next_page_token());
  } while (!request.page_token().empty());
  return sessions;
}

absl::StatusOr<v1::Session> Client::EndSession(const std::string& session) {
  v1::EndSessionRequest request;
  request.set_name(SessionName(session));
  return CallUnary(*connection_, stubs_->sessions, &v1::SessionService::Stub::EndSession, request);
}

}  // namespace semmap::client
