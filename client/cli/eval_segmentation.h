#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"
#include "slam/evaluation/class_confusion.h"
#include "slam/semantics/segmenter.h"

namespace semmap::client {

struct SegmentationEvalOptions {
  std::string model;   // description (YAML); empty: the one that ships with semmap
  std::string images;  // folder
  std::string labels;  // folder of class masks with the images' names (extensions may differ)
  // File with the names of the images to take, one a line, with or without extension; empty: all that have a
  // label.
  std::string list;
  std::string merge = "none";  // see FindClassMerge
  int threads = 0;
  int every = 1;  // only every n-th image
  bool json = false;
};

struct SegmentationEval {
  ClassConfusion confusion;
  int images = 0;
};

// Segments the images and compares their masks with the labels, at the labels' size. NOT_FOUND for files that
// are missing, INVALID_ARGUMENT for labels that are no class masks.
absl::StatusOr<SegmentationEval> EvaluateSegmentation(const SegmentationEvalOptions& options,
                                                      Segmenter* segmenter);

// The paper's Table 1: classes that count are numbers, Unlabeled is SKIP, classes without a pixel MISSING.
std::string SegmentationTable(const SegmentationEval& eval);
nlohmann::json SegmentationJson(const SegmentationEval& eval);

}  // namespace semmap::client
