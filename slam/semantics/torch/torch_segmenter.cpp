#include "slam/semantics/torch/torch_segmenter.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <thread>
#include <utility>

// Not torch/script.h, which is slow to compile.
#include <ATen/Parallel.h>
#include <ATen/core/Tensor.h>
#include <ATen/ops/empty.h>
#include <malloc.h>
#include <torch/csrc/jit/api/module.h>
#include <torch/csrc/jit/serialization/import.h>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/semantics/segmentation_model.h"

namespace semmap {
namespace {

// The first line says what happened, the rest is libtorch's call stack.
std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

int ThreadsOrCores(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// The network's own inputs and outputs. Everything of libtorch that throws is called from here, below
// Guarded.
class Network {
 public:
  explicit Network(SegmentationModel model) : model_(std::move(model)) {}

  void Load() {
    module_ = torch::jit::load(model_.file, c10::kCPU);
    module_.eval();
  }

  absl::StatusOr<at::Tensor> Forward(const at::Tensor& input) {
    const c10::InferenceMode no_gradients;
    const c10::IValue output = module_.forward({input});
    if (!output.isTensor()) return absl::InvalidArgumentError("forward() does not return a tensor");
    return CheckedScores(output.toTensor(), input);
  }

  const SegmentationModel& model() const { return model_; }

 private:
  absl::StatusOr<at::Tensor> CheckedScores(const at::Tensor& scores, const at::Tensor& input) const {
    const auto channels = static_cast<int64_t>(model_.class_of_channel->size());
    if (scores.dim() != 4 || scores.size(0) != input.size(0)) {
      return absl::InvalidArgumentError(
          absl::StrCat("forward() returns ", scores.dim(), " dimensions, must be images x channels x H x W"));
    }
    if (scores.size(1) != channels) {
      return absl::InvalidArgumentError(absl::StrCat("the network has ", scores.size(1),
                                                     " channels, its description ", channels, " classes"));
    }
    const int64_t stride = input.size(2) / std::max<int64_t>(scores.size(2), 1);
    const bool fits = (stride == 1 || stride == 2 || stride == 4) &&
                      scores.size(2) * stride == input.size(2) && scores.size(3) * stride == input.size(3);
    if (!fits) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the network returns ", scores.size(3), " x ", scores.size(2), " cells for an image of ",
          input.size(3), " x ", input.size(2), ", must be that, its half or its quarter"));
    }
    at::Tensor result = scores.to(c10::kFloat).contiguous();
    // A sum is a number only if all are.
    if (!std::isfinite(result.sum().item<float>())) return absl::InternalError("the scores are not numbers");
    return result;
  }

  const SegmentationModel model_;
  torch::jit::Module module_;
};

// A network asks for the same large blocks in every run. By default glibc returns them to the system each time,
// which clears them anew page by page: a quarter of a run. The bounds hold for the process.
void KeepFreedBlocks() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

template <typename Function>
auto Guarded(const Function& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& error) {
    return absl::InternalError(FirstLine(error.what()));
  }
}

class TorchSegmenter : public Segmenter {
 public:
  TorchSegmenter(SegmentationModel model, int threads) : network_(std::move(model)), threads_(threads) {}

  absl::Status Load() {
    const std::string& file = network_.model().file;
    std::error_code unreadable;
    if (!std::filesystem::is_regular_file(file, unreadable)) {
      return absl::NotFoundError(absl::StrCat("the network ", file, " is not there"));
    }
    const absl::Status loaded = Guarded([this] {
      network_.Load();
      return absl::OkStatus();
    });
    if (!loaded.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat(file, " is no TorchScript that this libtorch reads: ", loaded.message()));
    }
    const absl::Status tried = WarmUp();
    if (tried.ok()) return tried;
    return absl::InvalidArgumentError(absl::StrCat(file, ": ", tried.message()));
  }

  absl::StatusOr<std::vector<Segmentation>> Segment(std::span<const cv::Mat> images) override {
    for (const cv::Mat& image : images) {
      if (!image.empty() && (image.type() == CV_8UC3 || image.type() == CV_8UC1)) continue;
      return absl::InvalidArgumentError("images to segment are BGR or grey, with 8 bits a channel");
    }
    std::vector<Segmentation> segmentations;
    segmentations.reserve(images.size());
    for (size_t begin = 0, end = 0; begin < images.size(); begin = end) {
      const cv::Size size = network_.model().NetworkSize(images[begin].size());
      end = begin + 1;
      while (end < images.size() && network_.model().NetworkSize(images[end].size()) == size) ++end;
      SEMMAP_RETURN_IF_ERROR(
          Guarded([&] { return SegmentBatch(images.subspan(begin, end - begin), size, &segmentations); }));
    }
    return segmentations;
  }

 private:
  // Also gives libtorch the occasion to optimize, which it does in the first runs.
  absl::Status WarmUp() {
    constexpr int kRuns = 3;
    const cv::Mat image(network_.model().input_height, network_.model().input_width, CV_8UC3,
                        cv::Scalar(90, 120, 60));
    for (int i = 0; i < kRuns; ++i) {
      const auto segmented = Segment({&image, 1});
      if (!segmented.ok()) return segmented.status();
    }
    return absl::OkStatus();
  }

  absl::Status SegmentBatch(std::span<const cv::Mat> images, cv::Size size, std::vector<Segmentation>* out) {
    // Each thread has its own number in libtorch.
    if (at::get_num_threads() != threads_) at::set_num_threads(threads_);
    at::Tensor input = at::empty({static_cast<int64_t>(images.size()), 3, size.height, size.width});
    const auto image_size = static_cast<size_t>(3 * size.area());
    for (size_t i = 0; i < images.size(); ++i) {
      FillNetworkInput(network_.model(), images[i], size, input.data_ptr<float>() + i * image_size);
    }
    SEMMAP_ASSIGN_OR_RETURN(const at::Tensor scores, network_.Forward(input));
    const cv::Size grid(static_cast<int>(scores.size(3)), static_cast<int>(scores.size(2)));
    const auto values = static_cast<size_t>(scores.size(1) * grid.area());
    for (size_t i = 0; i < images.size(); ++i) {
      const float* begin = scores.data_ptr<float>() + i * values;
      out->emplace_back(images[i].size(), grid, std::vector<float>(begin, begin + values),
                        network_.model().class_of_channel);
    }
    return absl::OkStatus();
  }

  Network network_;
  const int threads_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Segmenter>> LoadTorchSegmenter(const std::string& model_path, int threads) {
  SEMMAP_ASSIGN_OR_RETURN(SegmentationModel model, SegmentationModel::FromFile(model_path));
  KeepFreedBlocks();
  auto segmenter = std::make_unique<TorchSegmenter>(std::move(model), ThreadsOrCores(threads));
  SEMMAP_RETURN_IF_ERROR(segmenter->Load());
  return segmenter;
}

absl::StatusOr<std::shared_ptr<SegmentationQueue>> LoadSegmentation(const SegmentationConfig& config) {
  if (config.mode == SegmentationMode::kOff) return nullptr;
  const std::string path = config.model.empty() ? DefaultSegmentationModelPath() : config.model;
  SEMMAP_ASSIGN_OR_RETURN(std::shared_ptr<Segmenter> segmenter, LoadTorchSegmenter(path, config.threads));
  return std::make_shared<SegmentationQueue>(std::move(segmenter),
                                             SegmentationQueue::Limits{config.max_batch, config.max_waiting});
}

}  // namespace semmap
