#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "slam/features/descriptor.h"

namespace semmap {

// A node's children lie in one piece: nodes [first, first + children). A leaf has none, and `first` is its
// word.
struct VocabularyNode {
  uint32_t first = 0;
  uint32_t children = 0;

  bool IsLeaf() const { return children == 0; }
  friend bool operator==(const VocabularyNode&, const VocabularyNode&) = default;
};
static_assert(sizeof(VocabularyNode) == 8);

// A hierarchical vocabulary (Nister and Stewenius, Scalable Recognition with a Vocabulary Tree, CVPR 2006)
// that lies in somebody else's memory. Nodes are in breadth-first order, the root first; words are numbered
// in the order of their leaves.
struct VocabularyView {
  uint32_t branching = 0;     // no node has more children
  uint32_t levels = 0;        // below the root; no leaf lies deeper
  uint32_t direct_level = 0;  // whose nodes group keypoints for matching, 0 (the root) to levels
  uint32_t training_images = 0;
  std::span<const VocabularyNode> nodes;
  std::span<const Descriptor> centres;  // by node; that of the root means nothing
  std::span<const float> idf;           // by word, finite and not negative; 0: the word says nothing
};

// The same with memory of its own: what training makes.
struct VocabularyTree {
  uint32_t branching = 0;
  uint32_t levels = 0;
  uint32_t direct_level = 0;
  uint32_t training_images = 0;
  std::vector<VocabularyNode> nodes;
  std::vector<Descriptor> centres;
  std::vector<float> idf;

  VocabularyView View() const {
    return {branching, levels, direct_level, training_images, nodes, centres, idf};
  }
};

// DATA_LOSS, with what is wrong, unless all that is said above holds: whoever descends from the root then
// arrives at a word within `levels` steps and reads nothing outside.
absl::Status CheckVocabulary(const VocabularyView& vocabulary);

}  // namespace semmap
