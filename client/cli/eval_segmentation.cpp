#include "client/cli/eval_segmentation.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "client/sources/file_list.h"
#include "client/sources/source_image.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct Pair {
  std::string image;
  std::string label;
};

std::string StemOf(const std::string& path) { return std::filesystem::path(path).stem(); }

absl::StatusOr<std::map<std::string, std::string>> FilesByStem(const std::string& folder) {
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> files, ListImages(folder));
  std::map<std::string, std::string> by_stem;
  for (const std::string& file : files) by_stem.emplace(StemOf(file), file);
  return by_stem;
}

absl::StatusOr<std::vector<std::string>> ReadNames(const std::string& path) {
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    const absl::string_view name = absl::StripAsciiWhitespace(line);
    if (!name.empty()) names.push_back(StemOf(std::string(name)));
  }
  return names;
}

absl::StatusOr<std::vector<Pair>> ListPairs(const SegmentationEvalOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(const auto images, FilesByStem(options.images));
  SEMMAP_ASSIGN_OR_RETURN(const auto labels, FilesByStem(options.labels));
  std::vector<Pair> pairs;
  if (options.list.empty()) {
    for (const auto& [stem, image] : images) {
      const auto label = labels.find(stem);
      if (label != labels.end()) pairs.push_back({image, label->second});
    }
  } else {
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> names, ReadNames(options.list));
    for (const std::string& name : names) {
      const auto image = images.find(name);
      const auto label = labels.find(name);
      if (image == images.end() || label == labels.end()) {
        return absl::NotFoundError(absl::StrCat(options.list, ": ", name, " has no image or no label"));
      }
      pairs.push_back({image->second, label->second});
    }
  }
  if (pairs.empty()) return absl::NotFoundError("no image has a label");
  return pairs;
}

// CARLA writes ids into the red channel of colour images.
absl::StatusOr<cv::Mat> ReadLabel(const std::string& path) {
  cv::Mat label = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (label.channels() > 1) cv::extractChannel(label, label, 2);
  if (label.type() != CV_8UC1 || label.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": is not an image of class ids"));
  }
  return label;
}

absl::StatusOr<cv::Mat> Predict(const Pair& pair, cv::Size size, Segmenter* segmenter) {
  SEMMAP_ASSIGN_OR_RETURN(const SourceImage source, ReadSourceImage(pair.image, false));
  SEMMAP_ASSIGN_OR_RETURN(const cv::Mat image, DecodeColour(source));
  if (image.size() != size) {
    return absl::InvalidArgumentError(absl::StrCat(pair.label, ": is not as large as ", pair.image));
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<Segmentation> segmented, segmenter->Segment({&image, 1}));
  cv::Mat classes;
  segmented.front().ToMasks(&classes, nullptr);
  return classes;
}

std::string NoteOf(const SegmentationEval& eval, uint8_t id) {
  if (id == static_cast<uint8_t>(SemanticClass::kUnlabeled)) return "SKIP";
  return eval.confusion.Accuracy(id).has_value() ? "" : "MISSING";
}

}  // namespace

absl::StatusOr<SegmentationEval> EvaluateSegmentation(const SegmentationEvalOptions& options,
                                                      Segmenter* segmenter) {
  SEMMAP_ASSIGN_OR_RETURN(const ClassMerge merge, FindClassMerge(options.merge));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<Pair> pairs, ListPairs(options));
  SegmentationEval eval{ClassConfusion(merge)};
  for (size_t i = 0; i < pairs.size(); i += static_cast<size_t>(options.every)) {
    SEMMAP_ASSIGN_OR_RETURN(const cv::Mat label, ReadLabel(pairs[i].label));
    SEMMAP_ASSIGN_OR_RETURN(const cv::Mat classes, Predict(pairs[i], label.size(), segmenter));
    SEMMAP_RETURN_IF_ERROR(eval.confusion.Add(label, classes));
    ++eval.images;
  }
  return eval;
}

std::string SegmentationTable(const SegmentationEval& eval) {
  std::string table = absl::StrFormat("%2s  %-13s %9s %9s\n", "ID", "Class label", "IoU", "Accuracy");
  for (uint8_t id = 0; id < kSemanticClassCount; ++id) {
    const std::string name(kSemanticClasses[id].name);
    const std::string note = NoteOf(eval, id);
    if (!note.empty()) {
      absl::StrAppendFormat(&table, "%2d  %-13s %9s %9s\n", id, name, note, note);
      continue;
    }
    absl::StrAppendFormat(&table, "%2d  %-13s %8.2f%% %8.2f%%\n", id, name,
                          100 * *eval.confusion.IntersectionOverUnion(id),
                          100 * *eval.confusion.Accuracy(id));
  }
  absl::StrAppendFormat(&table, "%d images, mean IoU over %d classes present %.4f, pixel accuracy %.4f\n",
                        eval.images, eval.confusion.ClassesPresent(), eval.confusion.MeanIoU(),
                        eval.confusion.PixelAccuracy());
  return table;
}

nlohmann::json SegmentationJson(const SegmentationEval& eval) {
  nlohmann::json classes = nlohmann::json::array();
  for (uint8_t id = 0; id < kSemanticClassCount; ++id) {
    nlohmann::json row = {{"id", id}, {"class", std::string(kSemanticClasses[id].name)}};
    const std::string note = NoteOf(eval, id);
    row["iou"] =
        note.empty() ? nlohmann::json(*eval.confusion.IntersectionOverUnion(id)) : nlohmann::json(note);
    row["accuracy"] = note.empty() ? nlohmann::json(*eval.confusion.Accuracy(id)) : nlohmann::json(note);
    classes.push_back(std::move(row));
  }
  return {{"images", eval.images},
          {"mean_iou", eval.confusion.MeanIoU()},
          {"pixel_accuracy", eval.confusion.PixelAccuracy()},
          {"classes_present", eval.confusion.ClassesPresent()},
          {"pixels", eval.confusion.pixels()},
          {"classes", classes}};
}

}  // namespace semmap::client
