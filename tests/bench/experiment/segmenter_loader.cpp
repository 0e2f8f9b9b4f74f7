#include "tests/bench/experiment/segmenter_loader.h"

#include "slam/semantics/segmentation_model.h"
#include "slam/semantics/torch/torch_segmenter.h"

namespace semmap::bench {

absl::StatusOr<std::unique_ptr<Segmenter>> LoadSegmenter(const std::string& model, int threads) {
  return LoadTorchSegmenter(model.empty() ? DefaultSegmentationModelPath() : model, threads);
}

}  // namespace semmap::bench
