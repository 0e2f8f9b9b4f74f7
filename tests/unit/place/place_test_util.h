#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "slam/place/vocabulary.h"

namespace semmap::testing {

inline Descriptor RandomDescriptor(std::mt19937_64& random) {
  Descriptor descriptor;
  for (uint64_t& word : descriptor.words) word = random();
  return descriptor;
}

// With `flips` bits drawn at random (with repetition) turned over.
inline Descriptor Perturbed(Descriptor descriptor, int flips, std::mt19937_64& random) {
  for (int i = 0; i < flips; ++i) {
    const uint64_t bit = random() % 256;
    descriptor.words[bit / 64] ^= uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

inline std::vector<Descriptor> RandomDescriptors(size_t count, std::mt19937_64& random) {
  std::vector<Descriptor> descriptors;
  for (size_t i = 0; i < count; ++i) descriptors.push_back(RandomDescriptor(random));
  return descriptors;
}

// A full tree of random centres, two levels deep, whose words all have idf 1 to 2.
inline VocabularyTree RandomTree(uint32_t branching, uint64_t seed) {
  std::mt19937_64 random(seed);
  VocabularyTree tree;
  tree.branching = branching;
  tree.levels = 2;
  tree.direct_level = 1;
  tree.training_images = 100;
  tree.nodes.push_back({1, branching});
  for (uint32_t i = 0; i < branching; ++i) tree.nodes.push_back({1 + branching * (i + 1), branching});
  for (uint32_t i = 0; i < branching * branching; ++i) {
    tree.nodes.push_back({i, 0});
    tree.idf.push_back(1.0F + static_cast<float>(random() % 1000) / 1000.0F);
  }
  tree.centres = RandomDescriptors(tree.nodes.size(), random);
  return tree;
}

inline std::shared_ptr<const Vocabulary> RandomVocabulary(uint32_t branching, uint64_t seed) {
  return Vocabulary::FromTree(RandomTree(branching, seed)).value();
}

}  // namespace semmap::testing
