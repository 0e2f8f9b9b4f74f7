#include "tests/support/place_oracle/place_oracle.h"

#include <algorithm>
#include <numeric>

#include <omp.h>

namespace semmap::testing {

ExactPlaceOracle::ExactPlaceOracle() : index_(256) {
  // FAISS's threads wait for each other actively, which takes many times longer where cores are busy.
  omp_set_num_threads(1);
}

std::vector<size_t> ExactPlaceOracle::Rank(std::span<const Descriptor> query) const {
  std::vector<int32_t> distances(query.size());
  std::vector<faiss::IndexBinary::idx_t> nearest(query.size());
  index_.search(static_cast<faiss::IndexBinary::idx_t>(query.size()), BytesOf(query), 1, distances.data(),
                nearest.data());
  std::vector<int> votes(images_, 0);
  for (const faiss::IndexBinary::idx_t descriptor : nearest) {
    if (descriptor >= 0) ++votes[image_of_[descriptor]];
  }
  std::vector<size_t> ranked(images_);
  std::iota(ranked.begin(), ranked.end(), 0);
  std::stable_sort(ranked.begin(), ranked.end(), [&](size_t a, size_t b) { return votes[a] > votes[b]; });
  return ranked;
}

}  // namespace semmap::testing
