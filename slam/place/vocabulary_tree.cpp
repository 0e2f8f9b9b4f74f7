#include "slam/place/vocabulary_tree.h"

#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap {
namespace {

absl::Status Broken(std::string_view reason) {
  return absl::DataLossError(absl::StrCat("vocabulary: ", std::string(reason)));
}

absl::Status CheckSizes(const VocabularyView& vocabulary) {
  if (vocabulary.nodes.empty()) return Broken("has no nodes");
  if (vocabulary.centres.size() != vocabulary.nodes.size()) return Broken("has not one centre for each node");
  if (vocabulary.direct_level > vocabulary.levels) return Broken("has its direct level below its leaves");
  return absl::OkStatus();
}

// In breadth-first order the children of each inner node follow those of the one before, so that two counters
// tell every link. Checks that, and that no path is longer than it may be.
absl::Status CheckLinks(const VocabularyView& vocabulary) {
  size_t next_child = 1;
  size_t next_word = 0;
  size_t level = 0;
  size_t level_end = 1;  // first node of the next level
  for (size_t i = 0; i < vocabulary.nodes.size(); ++i) {
    if (i == level_end) {
      ++level;
      level_end = next_child;
    }
    const VocabularyNode& node = vocabulary.nodes[i];
    if (node.children > vocabulary.branching)
      return Broken(absl::StrCat("node ", i, " has too many children"));
    if (node.first != (node.IsLeaf() ? next_word : next_child)) {
      return Broken(absl::StrCat("node ", i, " is out of order"));
    }
    next_child += node.children;
    next_word += node.IsLeaf() ? 1 : 0;
    if (next_child <= i + 1 && i + 1 < vocabulary.nodes.size()) return Broken("has nodes without a parent");
  }
  if (level > vocabulary.levels) return Broken("is deeper than it says");
  if (next_child != vocabulary.nodes.size()) return Broken("has links that lead nowhere");
  if (next_word != vocabulary.idf.size()) return Broken("has not one weight for each word");
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckVocabulary(const VocabularyView& vocabulary) {
  SEMMAP_RETURN_IF_ERROR(CheckSizes(vocabulary));
  SEMMAP_RETURN_IF_ERROR(CheckLinks(vocabulary));
  for (const float idf : vocabulary.idf) {
    if (!std::isfinite(idf) || idf < 0) return Broken("has a weight that is no weight");
  }
  return absl::OkStatus();
}

}  // namespace semmap
