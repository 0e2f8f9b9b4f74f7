#include <algorithm>
#include <memory>
#include <vector>

#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/start_operation.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

using Answer = absl::StatusOr<std::unique_ptr<google::protobuf::Message>>;

// Problems of the same kind are counted up to this many in total.
constexpr size_t kMaxFindings = 10000;

void AddFindings(const std::vector<storage::IntegrityFinding>& findings, v1::CheckMapResponse* response) {
  for (const storage::IntegrityFinding& finding : findings) {
    auto* problems = response->mutable_problems();
    auto same = std::find_if(problems->begin(), problems->end(),
                             [&](const v1::MapProblem& problem) { return problem.check() == finding.kind; });
    if (same == problems->end()) {
      v1::MapProblem* problem = response->add_problems();
      problem->set_check(finding.kind);
      problem->set_detail(finding.message);
      problem->set_count(1);
    } else {
      same->set_count(same->count() + 1);
    }
  }
}

Answer Check(const ServiceContext& context, storage::MapId map) {
  const auto findings = context.store->CheckIntegrity(map, kMaxFindings);
  if (!findings.ok()) return FromStore(findings.status());
  auto response = std::make_unique<v1::CheckMapResponse>();
  AddFindings(*findings, response.get());
  int64_t keyframes = 0;
  int64_t observations = 0;
  const absl::Status counted =
      context.store->ForEachKeyFrame(map, {}, [&](const storage::KeyFrameEntry& keyframe) {
        ++keyframes;
        observations += keyframe.observation_count;
        return true;
      });
  // A map that cannot be read is answered by its problems.
  if (!counted.ok() && !absl::IsDataLoss(counted)) return FromStore(counted);
  response->set_keyframes(keyframes);
  response->set_observations(observations);
  if (const auto info = context.store->GetMap(map); info.ok()) {
    response->set_points(static_cast<int64_t>(info->point_count));
  }
  return response;
}

Answer Repair(const ServiceContext& context, storage::MapId map) {
  SEMMAP_RETURN_IF_ERROR(FromStore(context.store->RepairMap(map)));
  context.watchers->OnReset(map);
  return Check(context, map);
}

}  // namespace

absl::StatusOr<v1::Operation> CheckMap(const ServiceContext& context, const v1::CheckMapRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
  return context.operations->Start(v1::OPERATION_KIND_CHECK, {map.name},
                                   [context, id = map.id](OperationProgress&) { return Check(context, id); });
}

absl::StatusOr<v1::Operation> RepairMap(const ServiceContext& context, const v1::RepairMapRequest& request) {
  return StartOperation(context, "RepairMap", request.request_id(), [&]() -> absl::StatusOr<v1::Operation> {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
    SEMMAP_RETURN_IF_ERROR(RequireUnused(context, map.name));
    return context.operations->Start(
        v1::OPERATION_KIND_REPAIR, {map.name},
        [context, id = map.id](OperationProgress&) { return Repair(context, id); });
  });
}

}  // namespace semmap::server
