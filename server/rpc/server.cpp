#include "server/rpc/server.h"

#include <algorithm>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/impl/service_type.h>
#include <spdlog/spdlog.h>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/rpc/call_runner.h"
#include "server/rpc/services.h"
#include "server/service_context.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr int kMaxMetadataBytes = 16 << 10;
// Operations are for the disk more than for the processor: one at a time is fastest.
constexpr int kOperationThreads = 1;
constexpr int kMapLoadingThreads = 1;
// Of the memory for maps, one in so many bytes is for parts of maps in any case.
constexpr size_t kLeastShareOfParts = 4;
// For streams to take their last message when the server stops.
constexpr auto kGrace = std::chrono::seconds(2);

int ThreadCount(int configured) {
  if (configured > 0) return configured;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

MapCache::Limits CacheLimits(const ServerConfig& config) {
  const size_t max_bytes = static_cast<size_t>(config.map_memory_mb) << 20;
  return {max_bytes, max_bytes / kLeastShareOfParts, absl::Seconds(config.map_reload_s)};
}

void SetLimits(const ServerConfig& config, grpc::ServerBuilder* builder) {
  const auto keepalive_ms = static_cast<int>(config.keepalive_s * 1e3);
  builder->SetMaxReceiveMessageSize(config.max_message_mb << 20);
  builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, config.max_streams_per_connection);
  builder->AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMaxMetadataBytes);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, keepalive_ms);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, keepalive_ms / 3);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Vehicles may ping as often as the server does.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, keepalive_ms / 2);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // Two servers on one port would each get a part of the vehicles.
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
}

class GrpcServer : public Server {
 public:
  GrpcServer(const Config& config, std::unique_ptr<storage::MapStore> store, SlamSessionFactory factory,
             std::shared_ptr<const Vocabulary> vocabulary, std::shared_ptr<SegmentationQueue> segmentation)
      : config_(config),
        vocabulary_(std::move(vocabulary)),
        store_(std::move(store)),
        writer_(std::make_unique<MapWriter>(static_cast<size_t>(config.server.writer_queue))),
        mappers_(MakeThreadPool(ThreadCount(config.server.mapping_threads))),
        trackers_(MakeThreadPool(ThreadCount(config.server.tracking_threads))),
        queries_(MakeThreadPool(config.server.query_threads)),
        workers_(MakeThreadPool(kOperationThreads)),
        loaders_(MakeThreadPool(kMapLoadingThreads)),
        map_parts_(std::make_shared<MapPartCache>(CacheLimits(config.server).max_bytes)),
        maps_(std::make_unique<MapCache>(CacheLimits(config.server),
                                         MakeMapLoader(store_.get(), config.slam, vocabulary_, map_parts_),
                                         loaders_.get(), map_parts_)),
        artifacts_(config.server.artifact_directory, int64_t{config.server.max_artifacts_mb} << 20,
                   absl::Seconds(config.server.artifact_lifetime_s), WallClock),
        sessions_(std::make_unique<SessionRegistry>(Environment(), config.slam, std::move(factory), &timer_)),
        operations_(std::make_unique<Operations>(workers_.get(), WallClock)),
        context_(Context(std::move(segmentation))),
        runner_(context_, queries_.get()) {}

  // Each pool finishes its tasks before those go that they use: queries and trackers first, the writer after
  // the mappers.
  ~GrpcServer() override {
    Drain();
    operations_.reset();
    workers_.reset();
    maps_.reset();
    loaders_.reset();
    queries_.reset();
    trackers_.reset();
    mappers_.reset();
    writer_.reset();
  }

  absl::Status Listen();
  int port() const override { return port_; }
  std::string address() const override { return absl::StrCat(Host(), ":", port_); }
  void Drain() override;

 private:
  SessionEnvironment Environment() {
    return {config_.server, store_.get(), trackers_.get(), mappers_.get(),
            writer_.get(),  &watchers_,   WallClock,       maps_.get()};
  }
  ServiceContext Context(std::shared_ptr<SegmentationQueue> segmentation) {
    return {config_.server,
            store_.get(),
            sessions_.get(),
            &requests_,
            &timer_,
            operations_.get(),
            &artifacts_,
            &watchers_,
            WallClock,
            config_.slam,
            maps_.get(),
            vocabulary_,
            std::move(segmentation)};
  }
  static TimestampNs WallClock() { return absl::GetCurrentTimeNanos(); }
  std::string Host() const { return config_.server.listen.substr(0, config_.server.listen.rfind(':')); }

  const Config config_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  std::unique_ptr<storage::MapStore> store_;
  std::unique_ptr<MapWriter> writer_;
  std::unique_ptr<Executor> mappers_;
  std::unique_ptr<Executor> trackers_;
  std::unique_ptr<Executor> queries_;
  std::unique_ptr<Executor> workers_;  // of operations
  std::unique_ptr<Executor> loaders_;  // of maps
  const std::shared_ptr<MapPartCache> map_parts_;
  std::unique_ptr<MapCache> maps_;
  RequestLog requests_;
  MapWatchers watchers_;
  Artifacts artifacts_;  // before the timer, which deletes them
  Timer timer_;
  std::unique_ptr<SessionRegistry> sessions_;
  std::unique_ptr<Operations> operations_;
  ServiceContext context_;
  CallRunner runner_;
  std::vector<std::unique_ptr<grpc::Service>> services_;
  std::unique_ptr<grpc::Server> grpc_;
  int port_ = 0;
  bool drained_ = false;
};

absl::Status GrpcServer::Listen() {
  services_.push_back(MakeSessionService(&runner_));
  services_.push_back(MakeMapService(&runner_));
  services_.push_back(MakeLocalizationService(&runner_));
  services_.push_back(MakeOperationService(&runner_));
  grpc::EnableDefaultHealthCheckService(true);
  // gRPC keeps the plugin for all servers of the process.
  static std::once_flag reflection_once;
  if (config_.server.reflection) {
    std::call_once(reflection_once, [] { grpc::reflection::InitProtoReflectionServerBuilderPlugin(); });
  }
  grpc::ServerBuilder builder;
  SetLimits(config_.server, &builder);
  builder.AddListeningPort(config_.server.listen, grpc::InsecureServerCredentials(), &port_);
  for (const auto& service : services_) builder.RegisterService(service.get());
  grpc_ = builder.BuildAndStart();
  if (grpc_ != nullptr && port_ != 0) {
    spdlog::info("listening address={} database={}", address(), config_.storage.uri);
    return absl::OkStatus();
  }
  return absl::UnavailableError(absl::StrCat("cannot listen on ", config_.server.listen));
}

void GrpcServer::Drain() {
  if (std::exchange(drained_, true) || grpc_ == nullptr) return;
  if (auto* health = grpc_->GetHealthCheckService()) health->SetServingStatus(false);
  spdlog::info("draining sessions={}", sessions_->size());
  sessions_->Drain(absl::Seconds(config_.server.drain_timeout_s));
  operations_->Stop();
  grpc_->Shutdown(std::chrono::system_clock::now() + kGrace);
  grpc_->Wait();
  spdlog::info("drained");
}

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const Config& config, SlamSessionFactory factory,
                                                      std::shared_ptr<const Vocabulary> vocabulary,
                                                      std::shared_ptr<SegmentationQueue> segmentation) {
  SEMMAP_ASSIGN_OR_RETURN(auto store, storage::OpenMapStore(config.storage));
  auto server = std::make_unique<GrpcServer>(config, std::move(store), std::move(factory),
                                             std::move(vocabulary), std::move(segmentation));
  SEMMAP_RETURN_IF_ERROR(server->Listen());
  return server;
}

}  // namespace semmap::server
