#include "slam/pipeline/place_memory.h"

namespace semmap {
namespace {

std::vector<uint32_t> TellingKeypoints(const FrameFeatures& features, const ClassSet& inactive) {
  std::vector<uint32_t> telling;
  telling.reserve(features.size());
  for (uint32_t i = 0; i < features.size(); ++i) {
    if (!inactive.Contains(features.keypoints[i].semantic_class)) telling.push_back(i);
  }
  return telling;
}

}  // namespace

PlaceMemory::PlaceMemory(std::shared_ptr<const Vocabulary> vocabulary, const PlaceQueryLimits& limits,
                         const ClassSet& inactive)
    : inactive_(inactive) {
  if (vocabulary != nullptr) index_.emplace(std::move(vocabulary), limits);
}

PlaceDescription PlaceMemory::Describe(const FrameFeatures& features) const {
  const std::vector<uint32_t> telling = TellingKeypoints(features, inactive_);
  if (telling.size() == features.size()) return index_->vocabulary().Describe(features.descriptors);
  std::vector<Descriptor> descriptors;
  descriptors.reserve(telling.size());
  for (const uint32_t keypoint : telling) descriptors.push_back(features.descriptors[keypoint]);
  PlaceDescription description = index_->vocabulary().Describe(descriptors);
  for (uint32_t& keypoint : description.nodes.keypoints) keypoint = telling[keypoint];
  return description;
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
