#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/connection.h"
#include "semmap/v1/localization_service.pb.h"
#include "semmap/v1/map_service.pb.h"
#include "semmap/v1/operation.pb.h"
#include "semmap/v1/session_service.pb.h"

namespace semmap::client {

// Asks a server about maps and sessions. Every call has a deadline (ConnectOptions::call_timeout) and fails
// with the server's status; errors.h tells its reason. Map and session arguments are ids or full names.
// Thread-safe.
class Client {
 public:
  // Return false to stop reading; the call then ends with CANCELLED.
  template <typename Message>
  using Consumer = std::function<bool(const Message&)>;

  // Called now and then while an operation runs; may be empty.
  using Progress = std::function<bool(const v1::OperationMetadata&)>;

  explicit Client(std::shared_ptr<Connection> connection);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  absl::StatusOr<v1::Map> CreateMap(const v1::Map& map);
  absl::StatusOr<v1::Map> GetMap(const std::string& map);
  // All pages.
  absl::StatusOr<std::vector<v1::Map>> ListMaps();
  // Changes the fields that `paths` names: "display_name", "labels", "anchor".
  absl::StatusOr<v1::Map> UpdateMap(const v1::Map& map, const std::vector<std::string>& paths);
  absl::Status DeleteMap(const std::string& map);
  absl::StatusOr<v1::Map> RenameMap(const std::string& map, const std::string& new_name);
  // These take long; they return when the server is done. A Progress that returns false cancels the operation
  // on the server, which then answers CANCELLED.
  absl::StatusOr<v1::Map> CopyMap(const std::string& map, const std::string& new_name,
                                  const Progress& progress);
  absl::StatusOr<v1::CheckMapResponse> CheckMap(const std::string& map, const Progress& progress);
  absl::StatusOr<v1::CheckMapResponse> RepairMap(const std::string& map, const Progress& progress);
  // Joins `source` to `target`; `request_id` is filled in.
  absl::StatusOr<v1::MergeMapsResponse> MergeMaps(v1::MergeMapsRequest request, const Progress& progress);
  struct Optimized {
    v1::Map map;
    v1::OptimizeReport report;
  };
  // 0 iterations: the server's choice.
  absl::StatusOr<Optimized> OptimizeMap(const std::string& map, int max_iterations, const Progress& progress);
  struct Pruned {
    v1::Map map;
    v1::PruneReport report;
  };
  absl::StatusOr<Pruned> PruneMap(v1::PruneMapRequest request, const Progress& progress);
  // Sends a map file in pieces: `read` fills the next bytes, at most as many as its argument has room for,
  // and answers how many, 0 at the end. `sha256` of the whole file, 32 bytes, or empty.
  absl::StatusOr<v1::Map> ImportMap(const std::string& map, const std::string& sha256,
                                    const std::function<absl::StatusOr<size_t>(std::span<char>)>& read,
                                    const Progress& progress);
  // The file is to be fetched by ReadArtifact; DeleteOperation of `operation` deletes it.
  struct Export {
    v1::ExportMapResponse file;
    std::string operation;
  };
  absl::StatusOr<Export> ExportMap(v1::ExportMapRequest request, const Progress& progress);
  // The bytes of a file from `offset` on, in pieces. `artifact` is the name that the export answered.
  absl::Status ReadArtifact(const std::string& artifact, int64_t offset,
                            const Consumer<v1::ReadArtifactResponse>& consumer);
  // One that is done, by its name.
  absl::Status DeleteOperation(const std::string& operation);
  absl::StatusOr<v1::MapSummary> GetMapSummary(const std::string& map);

  // Points arrive in pieces, in the order of their ids.
  absl::Status QueryMapPoints(v1::QueryMapPointsRequest request,
                              const Consumer<v1::QueryMapPointsResponse>& consumer);
  // All pages; `request.page_token` is ignored.
  absl::Status QueryKeyFrames(v1::QueryKeyFramesRequest request, const Consumer<v1::KeyFrame>& consumer);
  // Poses arrive in pieces, by session and sequence.
  absl::Status GetTrajectory(v1::GetTrajectoryRequest request,
                             const Consumer<v1::GetTrajectoryResponse>& consumer);

  // Where a picture was taken. One that cannot be found is no failure: the response says why.
  absl::StatusOr<v1::RelocalizeResponse> Relocalize(v1::RelocalizeRequest request);
  // All there is (unless it is of version `request.after_version`), then what changes, until the consumer
  // wants no more. RESOURCE_EXHAUSTED, WATCHER_TOO_SLOW: begin anew with the last version seen.
  absl::Status WatchMap(v1::WatchMapRequest request, const Consumer<v1::WatchMapResponse>& consumer);

  absl::StatusOr<v1::Session> GetSession(const std::string& session);
  // All pages; `request.page_token` is ignored.
  absl::StatusOr<std::vector<v1::Session>> ListSessions(v1::ListSessionsRequest request);
  absl::StatusOr<v1::Session> EndSession(const std::string& session);

 private:
  struct Stubs;
  // The operation when it is done.
  absl::StatusOr<v1::Operation> Await(absl::StatusOr<v1::Operation> operation, const Progress& progress);
  // Waits for the operation and unpacks its response.
  template <typename Response>
  absl::StatusOr<Response> Finish(absl::StatusOr<v1::Operation> operation, const Progress& progress,
                                  v1::Operation* done = nullptr);
  std::shared_ptr<Connection> connection_;
  std::unique_ptr<Stubs> stubs_;
};

}  // namespace semmap::client
