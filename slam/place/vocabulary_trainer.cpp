#include "slam/place/vocabulary_trainer.h"

#include <cmath>
#include <utility>

#include "absl/status/status.h"
#include "slam/common/status_macros.h"
#include "slam/place/hamming_medians.h"

namespace semmap {
namespace {

absl::Status CheckConfig(const VocabularyTrainingConfig& config) {
  if (config.branching < 2 || config.branching > 256) {
    return absl::InvalidArgumentError("branching must be between 2 and 256");
  }
  if (config.levels < 1 || config.levels > 8)
    return absl::InvalidArgumentError("levels must be between 1 and 8");
  if (config.direct_level < 0 || config.direct_level > config.levels) {
    return absl::InvalidArgumentError("the direct level must be between 0 and the number of levels");
  }
  return absl::OkStatus();
}

// The descriptors below a node lie in one piece, those of an image together within it.
struct Range {
  size_t begin = 0;
  size_t end = 0;

  size_t size() const { return end - begin; }
};

class Trainer {
 public:
  Trainer(std::span<const std::vector<Descriptor>> images, const VocabularyTrainingConfig& config);

  absl::StatusOr<VocabularyTree> Train(const VocabularyTrainingProgress& progress);

 private:
  void Visit(size_t node, bool may_split);
  void AddChildren(size_t node, const Medians& medians);
  void AddWord(size_t node);
  // Sorts the descriptors of a range by cluster, otherwise leaving their order; returns the clusters' ranges.
  std::vector<Range> Partition(const Range& range, const Medians& medians);

  VocabularyTrainingConfig config_;
  std::vector<Descriptor> descriptors_;
  std::vector<uint32_t> image_of_;  // by descriptor
  VocabularyTree tree_;
  std::vector<Range> ranges_;  // by node
};

Trainer::Trainer(std::span<const std::vector<Descriptor>> images, const VocabularyTrainingConfig& config)
    : config_(config) {
  for (size_t image = 0; image < images.size(); ++image) {
    descriptors_.insert(descriptors_.end(), images[image].begin(), images[image].end());
    image_of_.resize(descriptors_.size(), static_cast<uint32_t>(image));
  }
  tree_.branching = static_cast<uint32_t>(config.branching);
  tree_.levels = static_cast<uint32_t>(config.levels);
  tree_.direct_level = static_cast<uint32_t>(config.direct_level);
  tree_.training_images = static_cast<uint32_t>(images.size());
}

absl::StatusOr<VocabularyTree> Trainer::Train(const VocabularyTrainingProgress& progress) {
  if (descriptors_.empty()) return absl::InvalidArgumentError("there are no descriptors to learn from");
  tree_.nodes.emplace_back();
  tree_.centres.emplace_back();
  ranges_.push_back({0, descriptors_.size()});
  size_t begin = 0;
  for (int level = 0; level <= config_.levels; ++level) {
    const size_t end = tree_.nodes.size();
    for (size_t node = begin; node < end; ++node) Visit(node, level < config_.levels);
    if (progress && tree_.nodes.size() > end) progress(level + 1, tree_.nodes.size() - end);
    begin = end;
  }
  SEMMAP_RETURN_IF_ERROR(CheckVocabulary(tree_.View()));
  return std::move(tree_);
}

void Trainer::Visit(size_t node, bool may_split) {
  const Range range = ranges_[node];
  if (may_split && range.size() >= static_cast<size_t>(config_.min_descriptors)) {
    // Seeds differ between nodes but depend on nothing else.
    const MediansConfig medians_config{config_.branching, config_.max_iterations,
                                       config_.seed + node * 0x9E3779B97F4A7C15U};
    const Medians medians =
        ClusterByMedians(std::span(descriptors_).subspan(range.begin, range.size()), medians_config);
    if (medians.centres.size() > 1) {
      AddChildren(node, medians);
      return;
    }
  }
  AddWord(node);
}

void Trainer::AddChildren(size_t node, const Medians& medians) {
  tree_.nodes[node] = {static_cast<uint32_t>(tree_.nodes.size()),
                       static_cast<uint32_t>(medians.centres.size())};
  const std::vector<Range> ranges = Partition(ranges_[node], medians);
  ranges_.insert(ranges_.end(), ranges.begin(), ranges.end());
  tree_.centres.insert(tree_.centres.end(), medians.centres.begin(), medians.centres.end());
  tree_.nodes.resize(tree_.centres.size());
}

void Trainer::AddWord(size_t node) {
  tree_.nodes[node] = {static_cast<uint32_t>(tree_.idf.size()), 0};
  const Range& range = ranges_[node];
  size_t images = 0;
  for (size_t i = range.begin; i < range.end; ++i) {
    if (i == range.begin || image_of_[i] != image_of_[i - 1]) ++images;
  }
  tree_.idf.push_back(
      static_cast<float>(std::log(static_cast<double>(tree_.training_images) / static_cast<double>(images))));
}

std::vector<Range> Trainer::Partition(const Range& range, const Medians& medians) {
  std::vector<Range> ranges(medians.centres.size());
  std::vector<size_t> sizes(medians.centres.size(), 0);
  for (const uint32_t cluster : medians.cluster_of) ++sizes[cluster];
  size_t begin = range.begin;
  for (size_t i = 0; i < ranges.size(); ++i) {
    ranges[i] = {begin, begin};  // grows to its end below
    begin += sizes[i];
  }
  const auto first = static_cast<ptrdiff_t>(range.begin);
  const auto last = static_cast<ptrdiff_t>(range.end);
  const std::vector<Descriptor> descriptors(descriptors_.begin() + first, descriptors_.begin() + last);
  const std::vector<uint32_t> image_of(image_of_.begin() + first, image_of_.begin() + last);
  for (size_t i = 0; i < descriptors.size(); ++i) {
    const size_t place = ranges[medians.cluster_of[i]].end++;
    descriptors_[place] = descriptors[i];
    image_of_[place] = image_of[i];
  }
  return ranges;
}

}  // namespace

absl::StatusOr<VocabularyTree> TrainVocabulary(std::span<const std::vector<Descriptor>> images,
                                               const VocabularyTrainingConfig& config,
                                               const VocabularyTrainingProgress& progress) {
  SEMMAP_RETURN_IF_ERROR(CheckConfig(config));
  return Trainer(images, config).Train(progress);
}

}  // namespace semmap
