#include "tests/bench/place_bench_recall.h"

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <tuple>
#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/sources/file_list.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/recall.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/features/descriptor_search.h"
#include "slam/features/orb_extractor.h"
#include "slam/place/place_index.h"
#include "tests/support/place_oracle/place_oracle.h"

namespace semmap::bench {
namespace {

constexpr double kSamePlaceMetres = 5;
constexpr double kSamePlaceRadians = std::numbers::pi / 6;
constexpr size_t kSamePlaceSteps = 3;
constexpr size_t kBest = 5;
constexpr int kMaxMatchDistance = 50;
constexpr double kMaxMatchRatio = 0.8;

std::string ImageFolderOf(const std::string& folder) {
  for (const char* inner : {"image_0", "rgb"}) {
    const std::string path = client::JoinPath(folder, inner);
    if (client::FolderExists(path)) return path;
  }
  return folder;
}

bool IsSamePlace(const DescribedFrame& a, const DescribedFrame& b, size_t step) {
  if (a.map_from_camera && b.map_from_camera) {
    const PoseError apart = ComparePoses(*a.map_from_camera, *b.map_from_camera);
    return apart.translation_m <= kSamePlaceMetres && apart.rotation_rad <= kSamePlaceRadians;
  }
  return std::max(a.number, b.number) - std::min(a.number, b.number) <= kSamePlaceSteps * step;
}

struct Task {
  std::vector<const DescribedFrame*> database;
  std::vector<const DescribedFrame*> queries;
};

Task MakeTask(const Recording& recording) {
  Task task;
  for (const DescribedFrame& frame : recording.frames) {
    (frame.is_query ? task.queries : task.database).push_back(&frame);
  }
  std::erase_if(task.queries, [&](const DescribedFrame* query) {
    return std::none_of(task.database.begin(), task.database.end(), [&](const DescribedFrame* frame) {
      return IsSamePlace(*query, *frame, recording.spec.step);
    });
  });
  return task;
}

std::vector<Descriptor> EvenlySpread(const std::vector<Descriptor>& descriptors, size_t count) {
  if (descriptors.size() <= count) return descriptors;
  std::vector<Descriptor> chosen;
  for (size_t i = 0; i < count; ++i) chosen.push_back(descriptors[i * descriptors.size() / count]);
  return chosen;
}

// Counts queries that are answered rightly within the first and within the first five.
class RecallCounter {
 public:
  void Add(const std::vector<bool>& right) {
    ++queries_;
    at_1_ += !right.empty() && right[0] ? 1 : 0;
    at_5_ += std::find(right.begin(), right.end(), true) != right.end() ? 1 : 0;
  }
  Recall Result() const {
    const double queries = std::max(1, queries_);
    return {at_1_ / queries, at_5_ / queries};
  }

 private:
  int queries_ = 0;
  int at_1_ = 0;
  int at_5_ = 0;
};

std::vector<uint32_t> NodeOfEach(const PlaceDescription& place, size_t keypoints) {
  std::vector<uint32_t> nodes(keypoints, 0);
  for (const NodeGroup& group : place.nodes.groups) {
    for (uint32_t i = group.begin; i < group.end; ++i) nodes[place.nodes.keypoints[i]] = group.node;
  }
  return nodes;
}

// What matching within the nodes of the direct index keeps and costs.
class DirectIndexCounter {
 public:
  explicit DirectIndexCounter(const Vocabulary& vocabulary) : vocabulary_(vocabulary) {}

  void Add(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b) {
    const std::vector<uint32_t> nodes_a = NodeOfEach(vocabulary_.Describe(a), a.size());
    const std::vector<uint32_t> nodes_b = NodeOfEach(vocabulary_.Describe(b), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      const NearestTwo there = FindNearestTwo(a[i], b);
      if (there.distance > kMaxMatchDistance || there.distance > kMaxMatchRatio * there.second_distance)
        continue;
      if (FindNearestTwo(b[there.index], a).index != static_cast<int>(i)) continue;
      ++matches_;
      kept_ += nodes_a[i] == nodes_b[there.index] ? 1 : 0;
    }
    all_comparisons_ += static_cast<double>(a.size()) * static_cast<double>(b.size());
    for (const uint32_t node : nodes_a) {
      comparisons_ += static_cast<double>(std::count(nodes_b.begin(), nodes_b.end(), node));
    }
  }
  double KeptShare() const { return kept_ / std::max(1.0, matches_); }
  double ComparedShare() const { return comparisons_ / std::max(1.0, all_comparisons_); }

 private:
  const Vocabulary& vocabulary_;
  double matches_ = 0;
  double kept_ = 0;
  double comparisons_ = 0;
  double all_comparisons_ = 0;
};

std::string NameOf(const std::string& folder) {
  const std::filesystem::path path(folder);
  return path.filename() == "images" ? path.parent_path().filename() : path.filename();
}

Trajectory PosesOf(const std::string& folder) {
  for (const char* name : {"poses_town.txt", "poses.txt"}) {
    absl::StatusOr<Trajectory> poses = ReadKittiTrajectory(client::JoinPath(folder, name));
    if (poses.ok()) return *std::move(poses);
  }
  return {};
}

absl::StatusOr<std::vector<DescribedFrame>> ReadFrames(const std::string& folder, size_t step, int features) {
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> images, client::ListImages(ImageFolderOf(folder)));
  const Trajectory poses = PosesOf(folder);
  OrbConfig orb;
  orb.features = features;
  OrbExtractor extractor(orb);
  FrameFeatures extracted;
  std::vector<DescribedFrame> frames;
  for (size_t i = 0; i < images.size(); i += step) {
    extractor.Extract(cv::imread(images[i], cv::IMREAD_GRAYSCALE), &extracted);
    DescribedFrame& frame = frames.emplace_back();
    frame.number = i;
    frame.descriptors = extracted.descriptors;
    if (i < poses.size()) frame.map_from_camera = poses.poses[i].map_from_camera;
  }
  return frames;
}

}  // namespace

absl::StatusOr<RecordingSpec> ParseRecordingSpec(const std::string& text) {
  RecordingSpec spec;
  const size_t at = text.rfind('@');
  const std::pair<std::string, std::string> folders =
      absl::StrSplit(text.substr(0, at), absl::MaxSplits(',', 1));
  std::tie(spec.folder, spec.query_folder) = folders;
  if (at == std::string::npos) return spec;
  const std::vector<std::string> numbers = absl::StrSplit(text.substr(at + 1), ':');
  size_t split = 0;
  bool valid = numbers.size() <= 2 && absl::SimpleAtoi(numbers[0], &spec.step) && spec.step > 0;
  if (valid && numbers.size() == 2) {
    valid = absl::SimpleAtoi(numbers[1], &split);
    spec.split = split;
  }
  if (!valid) {
    return absl::InvalidArgumentError(absl::StrCat(text, ": expected FOLDER[,QUERY_FOLDER][@STEP[:SPLIT]]"));
  }
  return spec;
}

absl::StatusOr<Recording> ReadRecording(const RecordingSpec& spec, int features) {
  Recording recording;
  recording.spec = spec;
  recording.name = NameOf(spec.folder);
  SEMMAP_ASSIGN_OR_RETURN(recording.frames, ReadFrames(spec.folder, spec.step, features));
  for (size_t i = 0; i < recording.frames.size(); ++i) {
    DescribedFrame& frame = recording.frames[i];
    frame.is_query = spec.query_folder.empty() && (spec.split ? frame.number >= *spec.split : i % 2 == 1);
  }
  if (spec.query_folder.empty()) return recording;
  absl::StrAppend(&recording.name, " / ", NameOf(spec.query_folder));
  SEMMAP_ASSIGN_OR_RETURN(std::vector<DescribedFrame> queries,
                          ReadFrames(spec.query_folder, spec.step, features));
  for (DescribedFrame& query : queries) {
    query.is_query = true;
    recording.frames.push_back(std::move(query));
  }
  return recording;
}

RecallResult MeasureRecall(const Recording& recording, const std::shared_ptr<const Vocabulary>& vocabulary,
                           size_t oracle_descriptors) {
  const Task task = MakeTask(recording);
  PlaceIndex index(vocabulary);
  testing::ExactPlaceOracle oracle;
  for (size_t i = 0; i < task.database.size(); ++i) {
    oracle.Add(task.database[i]->descriptors);
    index.Add(KeyFrameId(i + 1), vocabulary->Describe(task.database[i]->descriptors).words);
  }
  RecallCounter exact_recall;
  RecallCounter index_recall;
  DirectIndexCounter direct(*vocabulary);
  int agreed = 0;
  for (const DescribedFrame* query : task.queries) {
    const auto same = [&](size_t i) { return IsSamePlace(*query, *task.database[i], recording.spec.step); };
    const auto ranked = oracle.Rank(EvenlySpread(query->descriptors, oracle_descriptors));
    std::vector<bool> right;
    for (size_t i = 0; i < std::min(kBest, ranked.size()); ++i) right.push_back(same(ranked[i]));
    exact_recall.Add(right);
    right.clear();
    for (const PlaceMatch& match : index.Query(vocabulary->Describe(query->descriptors).words, kBest)) {
      const size_t found = match.keyframe.value() - 1;
      right.push_back(same(found));
      agreed += found == ranked[0] ? 1 : 0;
    }
    index_recall.Add(right);
    direct.Add(query->descriptors, task.database[ranked[0]]->descriptors);
  }
  RecallResult result;
  result.name = recording.name;
  result.database = task.database.size();
  result.queries = task.queries.size();
  result.exact = exact_recall.Result();
  result.index = index_recall.Result();
  result.agreement = agreed / std::max(1.0, static_cast<double>(task.queries.size()));
  result.direct_matches = direct.KeptShare();
  result.direct_comparisons = direct.ComparedShare();
  return result;
}

}  // namespace semmap::bench
