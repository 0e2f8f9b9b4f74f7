#include "slam/pipeline/place_memory.h"

namespace semmap {
PlaceMemory::PlaceMemory(std::shared_ptr<const Vocabulary> vocabulary, const PlaceQueryLimits& limits,
                         const ClassSet& inactive) {
  if (vocabulary == nullptr) return;
  describer_.emplace(vocabulary, inactive);
  index_.emplace(std::move(vocabulary), limits);
}

void PlaceMemory::Add(const KeyFrame& keyframe) {
  if (!enabled()) return;
  PlaceDescription description = Describe(*keyframe.features);
  index_->Add(keyframe.id, std::move(description.words));
  nodes_[keyframe.id] = std::move(description.nodes);
}

void PlaceMemory::Remove(KeyFrameId id) {
  if (nodes_.erase(id) > 0) index_->Remove(id);
}

void PlaceMemory::Clear() {
  if (index_) index_->Clear();
  nodes_.clear();
}

const DirectIndex* PlaceMemory::NodesOf(KeyFrameId id) const {
  const auto found = nodes_.find(id);
  return found == nodes_.end() ? nullptr : &found->second;
}

}  // namespace semmap
