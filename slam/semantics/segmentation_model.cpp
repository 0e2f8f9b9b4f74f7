#include "slam/semantics/segmentation_model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "slam/common/config_reader.h"
#include "slam/common/data_files.h"
#include "slam/common/status_macros.h"
#include "slam/semantics/taxonomy.h"

namespace semmap {
namespace {

constexpr int kStride = 32;
constexpr int kMaxSide = 4096;

int RoundToStride(double length) {
  return std::max(kStride, static_cast<int>(std::lround(length / kStride)) * kStride);
}

void ReadTriple(ConfigReader& reader, const char* key, std::array<float, 3>* triple) {
  if (!reader.Has(key)) return;
  std::vector<double> values;
  reader.NumberList(key, &values, 3);
  if (values.size() != 3) {
    reader.Complain(key, "must have three numbers: red, green, blue");
    return;
  }
  std::transform(values.begin(), values.end(), triple->begin(),
                 [](double v) { return static_cast<float>(v); });
}

bool IsClass(double value) {
  return value == kUnknownClass || (value >= 0 && value < kSemanticClassCount && value == std::floor(value));
}

std::vector<uint8_t> ReadClassList(ConfigReader& reader) {
  std::vector<double> ids;
  reader.NumberList("classes", &ids, kMaxSegmentationChannels);
  if (!std::all_of(ids.begin(), ids.end(), IsClass)) {
    reader.Complain("classes", "must be CARLA ids (0 to 22), or 255 for none");
    return {};
  }
  if (ids.size() < 2) reader.Complain("classes", "must have two channels at least");
  return {ids.begin(), ids.end()};
}

std::vector<uint8_t> ReadClasses(ConfigReader& reader) {
  if (reader.HasList("classes")) return ReadClassList(reader);
  std::string name = "carla23";
  reader.Choice("classes", &name, {"carla23"});
  std::vector<uint8_t> classes(kSemanticClassCount);
  std::iota(classes.begin(), classes.end(), uint8_t{0});
  return classes;
}

}  // namespace

void SegmentationModel::Read(ConfigReader& reader) {
  reader.Text("file", &file);
  if (file.empty()) reader.Complain("file", "must name the TorchScript file");
  reader.Number("input_width", &input_width, kStride, kMaxSide);
  reader.Number("input_height", &input_height, kStride, kMaxSide);
  if (input_width % kStride != 0) reader.Complain("input_width", "must be a multiple of 32");
  if (input_height % kStride != 0) reader.Complain("input_height", "must be a multiple of 32");
  ReadTriple(reader, "mean", &mean);
  ReadTriple(reader, "std", &std);
  if (std::any_of(std.begin(), std.end(), [](float value) { return !(value > 0); })) {
    reader.Complain("std", "must be greater than 0");
  }
  class_of_channel = std::make_shared<const std::vector<uint8_t>>(ReadClasses(reader));
}

absl::StatusOr<SegmentationModel> SegmentationModel::FromFile(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(ConfigReader reader, ConfigReader::FromFile(path));
  SegmentationModel model;
  model.Read(reader);
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  model.file = std::filesystem::path(path).parent_path() / model.file;
  return model;
}

cv::Size SegmentationModel::NetworkSize(cv::Size image) const {
  const double area = static_cast<double>(input_width) * input_height;
  const double aspect = static_cast<double>(image.width) / image.height;
  return {RoundToStride(std::sqrt(area * aspect)), RoundToStride(std::sqrt(area / aspect))};
}

std::string DefaultSegmentationModelPath() { return DataFilePath("models/segmentation/street.yaml"); }

void FillNetworkInput(const SegmentationModel& model, const cv::Mat& image, cv::Size size, float* planes) {
  const bool shrinks = size.width < image.cols;
  cv::Mat resized;
  cv::resize(image, resized, size, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  const auto pixels = static_cast<size_t>(size.area());
  const int channels = resized.channels();
  const uint8_t* source = resized.data;
  for (size_t c = 0; c < 3; ++c) {
    const float scale = 1.0F / (255.0F * model.std[c]);
    const float offset = -model.mean[c] / model.std[c];
    // OpenCV keeps blue first.
    const size_t from = channels == 3 ? 2 - c : 0;
    float* plane = planes + c * pixels;
    for (size_t i = 0; i < pixels; ++i) {
      plane[i] = static_cast<float>(source[i * static_cast<size_t>(channels) + from]) * scale + offset;
    }
  }
}

}  // namespace semmap
