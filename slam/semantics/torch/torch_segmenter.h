#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "slam/semantics/segmentation_config.h"
#include "slam/semantics/segmentation_queue.h"
#include "slam/semantics/segmenter.h"

namespace semmap {

// Loads the network that a YAML file describes (slam/semantics/segmentation_model.h), and runs it once to see
// that it does what the description says. `threads` of one call; 0: one for each core. NOT_FOUND or
// INVALID_ARGUMENT name the file and the reason: no TorchScript, a number of channels other than that of
// classes, a grid that does not fit the image, scores that are not numbers.
absl::StatusOr<std::unique_ptr<Segmenter>> LoadTorchSegmenter(const std::string& model_path, int threads);

// What the sessions of a program share; null when the mode is off.
absl::StatusOr<std::shared_ptr<SegmentationQueue>> LoadSegmentation(const SegmentationConfig& config);

}  // namespace semmap
