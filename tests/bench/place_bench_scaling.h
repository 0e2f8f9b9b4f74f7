#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "slam/features/descriptor.h"
#include "slam/place/vocabulary.h"

namespace semmap::bench {

struct ScalingOptions {
  std::vector<size_t> sizes = {100, 1000, 10000, 100000};  // keyframes, rising
  size_t queries = 200;
  // Bits of each descriptor that are drawn (with repetition) and turned over, for keyframes and again for
  // queries: about what two views of one corner differ in.
  int flipped_bits = 20;
  uint64_t seed = 1;
};

// Times are CPU times of one thread, milliseconds.
struct ScalingRow {
  size_t keyframes = 0;
  double median_ms = 0;  // of a query for the ten best
  double p95_ms = 0;
  double exact_median_ms = 0;  // with all postings read
  // Queries made of one keyframe's descriptors, perturbed once more, whose best is that keyframe.
  double found = 0;
  double exact_found = 0;
  double bytes_per_keyframe = 0;  // of the index
  double add_ms = 0;              // mean
};

struct ScalingResult {
  double describe_ms = 0;  // median of an image, one thread
  double descriptors = 0;  // mean number in an image
  std::vector<ScalingRow> rows;
};

// Times queries while an index grows. Keyframe i has the descriptors of images[i % images.size()], perturbed.
ScalingResult MeasureScaling(const std::vector<std::vector<Descriptor>>& images,
                             const std::shared_ptr<const Vocabulary>& vocabulary,
                             const ScalingOptions& options);

// Median time of loading the file, which is in the page cache, milliseconds.
double MeasureLoad(const std::string& vocabulary_path);

}  // namespace semmap::bench
