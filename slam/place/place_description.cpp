#include "slam/place/place_description.h"

#include <algorithm>
#include <cstddef>

namespace semmap {

double Similarity(const BagOfWords& a, const BagOfWords& b) {
  // Both sum to 1, so that 1 - 0.5 sum |a_i - b_i| is the sum of min(a_i, b_i), in which only common words
  // count.
  double common = 0;
  size_t i = 0;
  size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (a[i].word == b[j].word) {
      common += std::min(a[i++].weight, b[j++].weight);
    } else if (a[i].word < b[j].word) {
      ++i;
    } else {
      ++j;
    }
  }
  return common;
}

}  // namespace semmap
