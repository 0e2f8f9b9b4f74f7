#include "slam/pipeline/session_mapper.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace semmap {

SessionMapper::SessionMapper(const SlamConfig& config, const MappingCamera& camera,
                             const ScalePyramidInfo& scale_info, std::shared_ptr<const Vocabulary> vocabulary,
                             LocalMapper::Publish publish)
    : config_(config),
      camera_(camera),
      local_(config, camera, scale_info, std::move(publish)),
      places_(std::move(vocabulary), config.place.query, config.semantics.InactiveClasses()),
      relocalizer_(config.relocalization, static_cast<uint32_t>(config.seed)),
      localizer_(config.relocalization, static_cast<uint32_t>(config.seed)) {}

void SessionMapper::Adopt(Map stored) {
  local_.mutable_map() = std::move(stored);
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : map().keyframes()) ids.push_back(id);
  // As if they had come one after the other.
  std::sort(ids.begin(), ids.end());
  for (const KeyFrameId id : ids) places_.Add(*map().FindKeyFrame(id));
}

VehicleMapping SessionMapper::StartVehicle(bool is_stranger) const {
  return {is_stranger, YoungPoints(), LoopCloser(config_.loop, static_cast<uint32_t>(config_.seed), camera_),
          KeyFrameId()};
}

void SessionMapper::AddKeyFrame(const KeyFrameCandidate& candidate, const std::atomic<bool>* stop,
                                VehicleMapping* vehicle) {
  vehicle->center = candidate.id;
  for (const KeyFrameId culled : local_.AddKeyFrame(candidate, stop, &vehicle->young_points))
    places_.Remove(culled);
  places_.Add(*map().FindKeyFrame(candidate.id));
}

void SessionMapper::AddInitialPair(const InitialPair& pair, VehicleMapping* vehicle) {
  vehicle->center = pair.second.id;
  local_.AddInitialPair(pair);
  places_.Add(*map().FindKeyFrame(pair.first.id));
  places_.Add(*map().FindKeyFrame(pair.second.id));
}

void SessionMapper::Reset(VehicleMapping* vehicle) {
  *vehicle = StartVehicle(vehicle->is_stranger);
  local_.Reset();
  places_.Clear();
}

std::optional<LoopCloser::Result> SessionMapper::CloseLoop(VehicleMapping* vehicle) {
  return vehicle->loop_closer.Close(vehicle->center, places_, &local_.mutable_map());
}

SessionMapper::Found SessionMapper::Find(const TrackedFrame& frame, const VehicleMapping& vehicle) const {
  const SearchImage image{*frame.features, *frame.grid};
  if (vehicle.is_stranger) {
    MapLocalization located = localizer_.Locate(map(), places_, camera_, image, PlacePrior(), 0);
    if (!located.found) return {nullptr, std::nullopt, located.failure};
    return {located.found->view, std::move(located.found->fix), LocalizationFailure::kNone};
  }
  Relocalization located = relocalizer_.Relocalize(map(), places_, camera_, image, 0);
  return {located.view, std::move(located.fix), located.failure};
}

SessionMapper::RecoveryReport SessionMapper::Recover(const LostFrame& lost, VehicleMapping* vehicle) {
  const TrackedFrame& frame = lost.frame;
  const Found found = Find(frame, *vehicle);
  if (!found.fix) return {nullptr, found.failure};
  if (!lost.IsBetter(found.fix->agreement)) return {nullptr, LocalizationFailure::kTooFewInliers};
  auto recovery = MakeRecovery(frame, *found.view, *found.fix);
  vehicle->center = recovery->reference;
  PublishView(*vehicle);
  return {std::move(recovery), LocalizationFailure::kNone};
}

PieceJoinReport SessionMapper::Join(const PieceJoin& join) {
  return JoinPiece(config_, camera_, join, &places_, &local_.mutable_map());
}

std::shared_ptr<FullBundle> SessionMapper::PrepareFullBundle() const {
  return std::make_shared<FullBundle>(config_.loop, camera_.model, map());
}

}  // namespace semmap
