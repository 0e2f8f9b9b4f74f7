#include "slam/pipeline/place_describer.h"

#include <utility>

namespace semmap {
namespace {

// FNV-1a over the members of the set, on top of the vocabulary's digest.
uint64_t FingerprintOf(uint64_t vocabulary, const ClassSet& inactive) {
  constexpr uint64_t kPrime = 1099511628211;
  uint64_t hash = vocabulary;
  for (int id = 0; id <= UINT8_MAX; ++id) {
    if (inactive.Contains(static_cast<uint8_t>(id))) hash = (hash ^ static_cast<uint64_t>(id + 1)) * kPrime;
  }
  return hash;
}

std::vector<Descriptor> Select(const std::vector<Descriptor>& descriptors,
                               const std::vector<uint32_t>& positions) {
  std::vector<Descriptor> selected;
  selected.reserve(positions.size());
  for (const uint32_t position : positions) selected.push_back(descriptors[position]);
  return selected;
}

}  // namespace

PlaceDescriber::PlaceDescriber(std::shared_ptr<const Vocabulary> vocabulary, const ClassSet& inactive)
    : vocabulary_(std::move(vocabulary)),
      inactive_(inactive),
      fingerprint_(FingerprintOf(vocabulary_->id(), inactive)) {}

std::vector<uint32_t> PlaceDescriber::TellingKeypoints(const FrameFeatures& features) const {
  std::vector<uint32_t> telling;
  telling.reserve(features.size());
  for (uint32_t i = 0; i < features.size(); ++i) {
    if (!inactive_.Contains(features.keypoints[i].semantic_class)) telling.push_back(i);
  }
  return telling;
}

PlaceDescription PlaceDescriber::Describe(const FrameFeatures& features) const {
  const std::vector<uint32_t> telling = TellingKeypoints(features);
  if (telling.size() == features.size()) return vocabulary_->Describe(features.descriptors);
  PlaceDescription description = vocabulary_->Describe(Select(features.descriptors, telling));
  for (uint32_t& keypoint : description.nodes.keypoints) keypoint = telling[keypoint];
  return description;
}

std::vector<WordId> PlaceDescriber::WordsOf(const FrameFeatures& features) const {
  const std::vector<uint32_t> telling = TellingKeypoints(features);
  if (telling.size() == features.size()) return vocabulary_->WordsOf(features.descriptors);
  return vocabulary_->WordsOf(Select(features.descriptors, telling));
}

}  // namespace semmap
