#include "client/client.h"

#include <utility>

#include <grpcpp/grpcpp.h>

#include "client/grpc_status.h"
#include "client/message_reader.h"
#include "client/names.h"
#include "client/request_id.h"
#include "semmap/v1/map_service.grpc.pb.h"
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

absl::Status Stopped() { return absl::CancelledError("the caller wanted no more"); }

}  // namespace

struct Client::Stubs {
  explicit Stubs(const std::shared_ptr<grpc::Channel>& channel) : maps(channel), sessions(channel) {}
  v1::MapService::Stub maps;
  v1::SessionService::Stub sessions;
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

absl::Status Client::DeleteMap(const std::string& map) {
  v1::DeleteMapRequest request;
  request.set_name(MapName(map));
  request.set_request_id(NewRequestId());
  return CallUnary(*connection_, stubs_->maps, &v1::MapService::Stub::DeleteMap, request).status();
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
