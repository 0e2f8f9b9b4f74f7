#include "slam/evaluation/class_confusion.h"

#include <initializer_list>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"

namespace semmap {
namespace {

using Member = std::pair<SemanticClass, SemanticClass>;  // what it is, what it counts as

ClassMerge MakeMerge(std::initializer_list<Member> members) {
  ClassMerge merge;
  std::iota(merge.begin(), merge.end(), uint8_t{0});
  for (const auto& [member, label] : members)
    merge[static_cast<uint8_t>(member)] = static_cast<uint8_t>(label);
  return merge;
}

bool Counts(uint8_t label) {
  return label != kUnknownClass && label != static_cast<uint8_t>(SemanticClass::kUnlabeled);
}

double Share(int64_t part, int64_t whole) { return static_cast<double>(part) / static_cast<double>(whole); }

}  // namespace

absl::StatusOr<ClassMerge> FindClassMerge(std::string_view name) {
  using enum SemanticClass;
  if (name == "none") return MakeMerge({});
  if (name == "carla") {
    return MakeMerge(
        {{kTrafficLight, kTrafficSign}, {kTerrain, kVegetation}, {kStatic, kOther}, {kDynamic, kOther}});
  }
  if (name == "camvid11") {
    return MakeMerge({{kRoadLine, kRoad},
                      {kWall, kBuilding},
                      {kBridge, kBuilding},
                      {kTrafficLight, kTrafficSign},
                      {kTerrain, kVegetation}});
  }
  return absl::InvalidArgumentError(absl::StrCat("there is no merge of classes named ", std::string(name)));
}

absl::Status ClassConfusion::Add(const cv::Mat& label, const cv::Mat& prediction) {
  if (label.size() != prediction.size() || label.type() != CV_8UC1 || prediction.type() != CV_8UC1) {
    return absl::InvalidArgumentError("label and prediction are not class masks of one size");
  }
  for (int y = 0; y < label.rows; ++y) {
    const auto* labels = label.ptr<uint8_t>(y);
    const auto* predictions = prediction.ptr<uint8_t>(y);
    for (int x = 0; x < label.cols; ++x) {
      const uint8_t id = labels[x];
      if (!Counts(id)) continue;
      if (id >= kSemanticClassCount) {
        return absl::InvalidArgumentError(absl::StrCat("the label has the id ", id, ", which is no class"));
      }
      const uint8_t said = merge_[predictions[x]];
      ++pixels_;
      ++labelled_[id];
      ++predicted_[said];
      if (said == id) ++hits_[id];
    }
  }
  return absl::OkStatus();
}

std::optional<double> ClassConfusion::IntersectionOverUnion(uint8_t id) const {
  if (id >= kSemanticClassCount || labelled_[id] == 0) return std::nullopt;
  return Share(hits_[id], labelled_[id] + predicted_[id] - hits_[id]);
}

std::optional<double> ClassConfusion::Accuracy(uint8_t id) const {
  if (id >= kSemanticClassCount || labelled_[id] == 0) return std::nullopt;
  return Share(hits_[id], labelled_[id]);
}

int ClassConfusion::ClassesPresent() const {
  int present = 0;
  for (const int64_t pixels : labelled_) present += pixels > 0 ? 1 : 0;
  return present;
}

double ClassConfusion::MeanIoU() const {
  double sum = 0;
  for (uint8_t id = 0; id < kSemanticClassCount; ++id) sum += IntersectionOverUnion(id).value_or(0.0);
  return ClassesPresent() == 0 ? 0.0 : sum / ClassesPresent();
}

double ClassConfusion::PixelAccuracy() const {
  if (pixels_ == 0) return 0.0;
  return Share(std::accumulate(hits_.begin(), hits_.end(), int64_t{0}), pixels_);
}

}  // namespace semmap
