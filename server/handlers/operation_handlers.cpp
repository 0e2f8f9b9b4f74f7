#include "server/handlers/operation_handlers.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include "semmap/v1/map_service.pb.h"
#include "server/error_reasons.h"
#include "server/names.h"
#include "server/page_token.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr absl::Duration kLongestWait = absl::Seconds(60);

absl::StatusOr<absl::Duration> ReadTimeout(const v1::WaitOperationRequest& request) {
  if (!request.has_timeout()) return kLongestWait;
  const absl::Duration timeout =
      absl::Seconds(request.timeout().seconds()) + absl::Nanoseconds(request.timeout().nanos());
  if (timeout >= absl::ZeroDuration()) return std::min(timeout, kLongestWait);
  return Error(v1::ERROR_REASON_FIELD_INVALID, "the timeout is negative", {{"field", "timeout"}});
}

}  // namespace

absl::StatusOr<v1::Operation> GetOperation(const ServiceContext& context,
                                           const v1::GetOperationRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseOperationName("name", request.name()));
  return context.operations->Get(id);
}

absl::StatusOr<v1::ListOperationsResponse> ListOperations(const ServiceContext& context,
                                                          const v1::ListOperationsRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const int page, ReadPageSize(request.page_size()));
  std::string map_id;
  if (!request.map().empty()) {
    SEMMAP_ASSIGN_OR_RETURN(map_id, ParseMapName("map", request.map()));
  }
  const std::string scope = "ListOperations " + map_id;
  SEMMAP_ASSIGN_OR_RETURN(const std::string after, ReadPageToken(scope, request.page_token()));
  std::vector<v1::Operation> operations = context.operations->List(map_id);
  auto next = operations.begin();
  if (!after.empty()) {
    // One that was forgotten meanwhile ends the list.
    next = std::find_if(next, operations.end(),
                        [&](const v1::Operation& other) { return other.name() == after; });
    if (next != operations.end()) ++next;
  }
  v1::ListOperationsResponse response;
  for (; next != operations.end() && response.operations_size() < page; ++next) {
    *response.add_operations() = std::move(*next);
  }
  if (next != operations.end()) {
    response.set_next_page_token(MakePageToken(scope, response.operations(page - 1).name()));
  }
  return response;
}

absl::StatusOr<google::protobuf::Empty> CancelOperation(const ServiceContext& context,
                                                        const v1::CancelOperationRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseOperationName("name", request.name()));
  SEMMAP_RETURN_IF_ERROR(context.operations->Cancel(id));
  return google::protobuf::Empty();
}

absl::StatusOr<google::protobuf::Empty> DeleteOperation(const ServiceContext& context,
                                                        const v1::DeleteOperationRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseOperationName("name", request.name()));
  SEMMAP_ASSIGN_OR_RETURN(const v1::Operation operation, context.operations->Get(id));
  SEMMAP_RETURN_IF_ERROR(context.operations->Forget(id));
  v1::ExportMapResponse exported;
  if (operation.response().UnpackTo(&exported)) {
    SEMMAP_ASSIGN_OR_RETURN(const std::string artifact, ParseArtifactName("artifact", exported.artifact()));
    context.artifacts->Remove(artifact);
  }
  return google::protobuf::Empty();
}

void WaitOperation(const ServiceContext& context, const v1::WaitOperationRequest& request,
                   std::function<void(absl::StatusOr<v1::Operation>)> done) {
  const auto id = ParseOperationName("name", request.name());
  const auto timeout = ReadTimeout(request);
  if (!id.ok() || !timeout.ok()) {
    done(id.ok() ? timeout.status() : id.status());
    return;
  }
  // Of the operation's end and the timer, who comes first answers.
  struct Answer {
    std::atomic<bool> given = false;
    std::function<void(absl::StatusOr<v1::Operation>)> done;
  };
  const auto answer = std::make_shared<Answer>();
  answer->done = std::move(done);
  const absl::Status waiting = context.operations->WhenDone(*id, [answer](const v1::Operation& operation) {
    if (!answer->given.exchange(true)) answer->done(operation);
  });
  if (!waiting.ok()) {
    answer->done(waiting);
    return;
  }
  if (answer->given) return;
  context.timer->After(*timeout, [answer, operations = context.operations, id = *id] {
    if (!answer->given.exchange(true)) answer->done(operations->Get(id));
  });
}

}  // namespace semmap::server
