#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <faiss/IndexBinaryFlat.h>

#include "slam/features/descriptor.h"

namespace semmap::testing {

// Ranks images by exact search: each descriptor of a query votes for the image that holds its nearest
// neighbour among all descriptors of all images (FAISS's exhaustive binary index). What any index
// approximates.
class ExactPlaceOracle {
 public:
  ExactPlaceOracle();

  // Images are numbered from 0 in the order they are added.
  void Add(std::span<const Descriptor> descriptors) {
    index_.add(static_cast<faiss::IndexBinary::idx_t>(descriptors.size()), BytesOf(descriptors));
    image_of_.resize(image_of_.size() + descriptors.size(), images_++);
  }

  // All images, most votes first, of equal ones the earlier.
  std::vector<size_t> Rank(std::span<const Descriptor> query) const;

 private:
  static const uint8_t* BytesOf(std::span<const Descriptor> descriptors) {
    return reinterpret_cast<const uint8_t*>(descriptors.data());
  }

  faiss::IndexBinaryFlat index_;
  std::vector<size_t> image_of_;  // by descriptor
  size_t images_ = 0;
};

}  // namespace semmap::testing
