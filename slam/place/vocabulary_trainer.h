#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/features/descriptor.h"
#include "slam/place/vocabulary_tree.h"

namespace semmap {

struct VocabularyTrainingConfig {
  int branching = 10;    // 2 to 256
  int levels = 5;        // 1 to 8
  int direct_level = 2;  // 0 to levels
  // Nodes with fewer descriptors are not split: their words would stand for single descriptors.
  int min_descriptors = 20;
  int max_iterations = 12;  // of k-medians, at each node
  uint64_t seed = 1;
};

// Called after each level of the tree with its number (from 1) and how many nodes it has.
using VocabularyTrainingProgress = std::function<void(int level, size_t nodes)>;

// Learns a vocabulary from the descriptors of images, images[i] being those of one: hierarchical k-medians
// (Galvez-Lopez and Tardos, T-RO 2012, section III), and for each word idf = ln(images / images that have
// it). Deterministic. Takes about 100 bytes for each descriptor besides. INVALID_ARGUMENT for settings out of
// bounds and when there are no descriptors.
absl::StatusOr<VocabularyTree> TrainVocabulary(std::span<const std::vector<Descriptor>> images,
                                               const VocabularyTrainingConfig& config,
                                               const VocabularyTrainingProgress& progress = {});

}  // namespace semmap
