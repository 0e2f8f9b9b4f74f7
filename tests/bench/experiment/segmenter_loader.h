#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "slam/semantics/segmenter.h"

namespace semmap::bench {

// The network that the YAML file describes; empty: the one that ships with semmap.
absl::StatusOr<std::unique_ptr<Segmenter>> LoadSegmenter(const std::string& model, int threads);

}  // namespace semmap::bench
