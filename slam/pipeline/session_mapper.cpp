#include "slam/pipeline/session_mapper.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace semmap {
namespace {

// So many times the trust that the doubted place deserves.
constexpr double kBetter = 1.5;

}  // namespace

SessionMapper::SessionMapper(const SlamConfig& config, const MappingCamera& camera,
                             const ScalePyramidInfo& scale_info, std::shared_ptr<const Vocabulary> vocabulary,
                             LocalMapper::Publish publish)
    : config_(config),
      camera_(camera),
      local_(config, camera, scale_info, std::move(publish)),
      places_(std::move(vocabulary), config.place.query, config.semantics.InactiveClasses()),
      loop_closer_(config.loop, static_cast<uint32_t>(config.seed), camera),
      relocalizer_(config.relocalization, static_cast<uint32_t>(config.seed)),
      localizer_(config.relocalization, static_cast<uint32_t>(config.seed)) {}

void SessionMapper::Adopt(Map stored) {
  map_is_stored_ = true;
  local_.mutable_map() = std::move(stored);
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : map().keyframes()) ids.push_back(id);
  // As if they had come one after the other.
  std::sort(ids.begin(), ids.end());
  for (const KeyFrameId id : ids) places_.Add(*map().FindKeyFrame(id));
}

void SessionMapper::AddKeyFrame(const KeyFrameCandidate& candidate, const std::atomic<bool>* stop) {
  for (const KeyFrameId culled : local_.AddKeyFrame(candidate, stop)) places_.Remove(culled);
  places_.Add(*map().FindKeyFrame(candidate.id));
}

void SessionMapper::AddInitialPair(const InitialPair& pair) {
  local_.AddInitialPair(pair);
  places_.Add(*map().FindKeyFrame(pair.first.id));
  places_.Add(*map().FindKeyFrame(pair.second.id));
}

void SessionMapper::Reset() {
  local_.Reset();
  places_.Clear();
  loop_closer_.Reset();
}

std::optional<LoopCloser::Result> SessionMapper::CloseLoop() {
  auto closed = loop_closer_.Close(map().newest_keyframe(), places_, &local_.mutable_map());
  if (closed) local_.PublishView();
  return closed;
}

SessionMapper::Found SessionMapper::Find(const TrackedFrame& frame) const {
  const SearchImage image{*frame.features, *frame.grid};
  if (map_is_stored_) {
    MapLocalization located = localizer_.Locate(map(), places_, camera_, image, PlacePrior(), 0);
    if (!located.found) return {nullptr, std::nullopt, located.failure};
    return {located.found->view, std::move(located.found->fix), LocalizationFailure::kNone};
  }
  Relocalization located = relocalizer_.Relocalize(map(), places_, camera_, image, 0);
  return {located.view, std::move(located.fix), located.failure};
}

SessionMapper::RecoveryReport SessionMapper::Recover(const LostFrame& lost) {
  const TrackedFrame& frame = lost.frame;
  const Found found = Find(frame);
  if (!found.fix) return {nullptr, found.failure};
  if (found.fix->agreement.Trust() <= kBetter * lost.agreement.Trust())
    return {nullptr, LocalizationFailure::kTooFewInliers};
  auto recovery = std::make_shared<Recovery>();
  recovery->frame = frame;
  recovery->frame.camera_from_map = found.fix->camera_from_map;
  recovery->reference = found.view->reference().id;
  recovery->points.assign(frame.features->size(), MapPointId());
  for (size_t i = 0; i < found.fix->matches.size(); ++i) {
    if (found.fix->matches[i] >= 0) recovery->points[i] = found.view->ids[found.fix->matches[i]];
  }
  local_.FocusOn(recovery->reference);
  return {std::move(recovery), LocalizationFailure::kNone};
}

std::shared_ptr<FullBundle> SessionMapper::PrepareFullBundle() const {
  return std::make_shared<FullBundle>(config_.loop, camera_.model, map());
}

void SessionMapper::Apply(const FullBundle& bundle) {
  bundle.Apply(&local_.mutable_map());
  local_.PublishView();
}

}  // namespace semmap
