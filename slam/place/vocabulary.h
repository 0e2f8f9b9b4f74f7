#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/common/mapped_file.h"
#include "slam/features/descriptor.h"
#include "slam/place/place_config.h"
#include "slam/place/place_description.h"
#include "slam/place/vocabulary_tree.h"

namespace semmap {

// Turns an image's descriptors into words: each descends from the root of a tree to the nearest centre at
// each level (Nister and Stewenius, CVPR 2006, on binary descriptors as in Galvez-Lopez and Tardos, T-RO
// 2012). Immutable and thread-safe. Bags of one vocabulary cannot be compared with those of another: `id`
// tells them apart.
class Vocabulary {
 public:
  // Maps a file (slam/place/vocabulary_file.h) into memory. Statuses name the file: NOT_FOUND,
  // INVALID_ARGUMENT for another kind or version of file, DATA_LOSS for one that is cut off or damaged.
  static absl::StatusOr<std::shared_ptr<const Vocabulary>> Load(const std::string& path);
  // Of a tree in memory: after training, and in tests. DATA_LOSS if it is none.
  static absl::StatusOr<std::shared_ptr<const Vocabulary>> FromTree(VocabularyTree tree);

  // Bag and direct index; the order of the descriptors plays no part in the bag. The weight of a word is the
  // number of descriptors that fell on it times its idf, divided by the sum over all words; words of idf 0
  // are left out.
  PlaceDescription Describe(std::span<const Descriptor> descriptors) const;
  // The word of each descriptor, ascending; and the bag that Describe makes of such words.
  std::vector<WordId> WordsOf(std::span<const Descriptor> descriptors) const;
  BagOfWords Weigh(std::span<const WordId> words) const;

  size_t words() const { return view_.idf.size(); }
  size_t branching() const { return view_.branching; }
  size_t levels() const { return view_.levels; }
  size_t direct_level() const { return view_.direct_level; }
  const VocabularyView& view() const { return view_; }
  // A digest of the content, the same on every machine.
  uint64_t id() const { return id_; }

 private:
  using Memory = std::variant<MappedFile, VocabularyTree>;
  // Where a descriptor arrived.
  struct Place {
    WordId word = 0;
    uint32_t direct_node = 0;
  };

  Vocabulary(Memory memory, const VocabularyView& view, uint64_t id)
      : memory_(std::move(memory)), view_(view), id_(id) {}
  Place Descend(const Descriptor& descriptor) const;

  Memory memory_;
  VocabularyView view_;
  uint64_t id_;
};

// The vocabulary of the configuration, or the one that ships with semmap. Statuses as Vocabulary::Load.
absl::StatusOr<std::shared_ptr<const Vocabulary>> LoadVocabulary(const PlaceConfig& config);

// Path of the vocabulary that ships with semmap (slam/common/data_files.h says where it is looked for).
std::string DefaultVocabularyPath();

}  // namespace semmap
