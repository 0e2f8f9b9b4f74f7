#include "slam/place/vocabulary.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "slam/common/data_files.h"
#include "slam/common/status_macros.h"
#include "slam/features/descriptor_search.h"
#include "slam/place/vocabulary_file.h"

namespace semmap {
namespace {

// Sorts keypoints by the node they fell below; `nodes` is by keypoint.
DirectIndex GroupByNode(const std::vector<uint32_t>& nodes) {
  // Node and keypoint in one number, which sorts faster than an index with a comparison through it.
  std::vector<uint64_t> order(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) order[i] = (uint64_t{nodes[i]} << 32U) | i;
  std::sort(order.begin(), order.end());
  DirectIndex index;
  index.keypoints.reserve(order.size());
  for (const uint64_t entry : order) {
    const auto node = static_cast<uint32_t>(entry >> 32U);
    const auto position = static_cast<uint32_t>(index.keypoints.size());
    if (index.groups.empty() || index.groups.back().node != node) {
      index.groups.push_back({node, position, position});
    }
    ++index.groups.back().end;
    index.keypoints.push_back(static_cast<uint32_t>(entry));
  }
  return index;
}

absl::Status Naming(const std::string& path, const absl::Status& status) {
  return {status.code(), absl::StrCat(path, ": ", status.message())};
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Vocabulary>> Vocabulary::Load(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(MappedFile file, MappedFile::Open(path));
  const absl::StatusOr<VocabularyView> view = DecodeVocabulary(file.bytes());
  if (!view.ok()) return Naming(path, view.status());
  const uint64_t id = DigestOf(file.bytes());
  return std::shared_ptr<const Vocabulary>(new Vocabulary(std::move(file), *view, id));
}

absl::StatusOr<std::shared_ptr<const Vocabulary>> Vocabulary::FromTree(VocabularyTree tree) {
  // The view's spans stay valid when the tree's vectors are moved.
  const VocabularyView view = tree.View();
  SEMMAP_RETURN_IF_ERROR(CheckVocabulary(view));
  const std::string bytes = EncodeVocabulary(view);
  const uint64_t id = DigestOf(std::as_bytes(std::span(bytes)));
  return std::shared_ptr<const Vocabulary>(new Vocabulary(std::move(tree), view, id));
}

Vocabulary::Place Vocabulary::Descend(const Descriptor& descriptor) const {
  Place place;
  uint32_t node = 0;
  for (size_t level = 0; !view_.nodes[node].IsLeaf(); ++level) {
    const VocabularyNode& parent = view_.nodes[node];
    const auto children = view_.centres.subspan(parent.first, parent.children);
    node = parent.first + static_cast<uint32_t>(FindNearestTwo(descriptor, children).index);
    // A leaf above the direct level stands for its own group.
    if (level < view_.direct_level) place.direct_node = node;
  }
  place.word = view_.nodes[node].first;
  return place;
}

BagOfWords Vocabulary::Weigh(std::span<const WordId> words) const {
  BagOfWords bag;
  bag.reserve(words.size());
  double sum = 0;
  for (const WordId word : words) {
    if (word >= view_.idf.size()) break;
    const float idf = view_.idf[word];
    if (idf == 0) continue;
    if (bag.empty() || bag.back().word != word) bag.push_back({word, 0});
    bag.back().weight += idf;
    sum += idf;
  }
  for (WordWeight& entry : bag) entry.weight = static_cast<float>(entry.weight / sum);
  return bag;
}

PlaceDescription Vocabulary::Describe(std::span<const Descriptor> descriptors) const {
  std::vector<WordId> words;
  std::vector<uint32_t> nodes;
  words.reserve(descriptors.size());
  nodes.reserve(descriptors.size());
  for (const Descriptor& descriptor : descriptors) {
    const Place place = Descend(descriptor);
    words.push_back(place.word);
    nodes.push_back(place.direct_node);
  }
  std::sort(words.begin(), words.end());
  return {Weigh(words), GroupByNode(nodes)};
}

std::vector<WordId> Vocabulary::WordsOf(std::span<const Descriptor> descriptors) const {
  std::vector<WordId> words;
  words.reserve(descriptors.size());
  for (const Descriptor& descriptor : descriptors) words.push_back(Descend(descriptor).word);
  std::sort(words.begin(), words.end());
  return words;
}

absl::StatusOr<std::shared_ptr<const Vocabulary>> LoadVocabulary(const PlaceConfig& config) {
  return Vocabulary::Load(config.vocabulary.empty() ? DefaultVocabularyPath() : config.vocabulary);
}

std::string DefaultVocabularyPath() { return DataFilePath("models/vocabulary/street.vocabulary"); }

}  // namespace semmap
