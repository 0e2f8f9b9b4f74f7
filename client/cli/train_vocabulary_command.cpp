// semmap train-vocabulary: learns the words of place recognition from folders of images, offline.

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <system_error>

#include <opencv2/imgcodecs.hpp>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/commands.h"
#include "client/cli/table.h"
#include "client/sources/file_list.h"
#include "slam/common/status_macros.h"
#include "slam/features/orb_extractor.h"
#include "slam/place/vocabulary_file.h"
#include "slam/place/vocabulary_trainer.h"

namespace semmap::client {
namespace {

constexpr size_t kImagesBetweenReports = 100;

struct TrainOptions {
  std::vector<std::string> folders;
  std::vector<std::string> held_out;
  std::string output;
  OrbConfig orb;
  VocabularyTrainingConfig training;
};

// Images of a folder and of all folders below it, every `step`-th of each.
absl::StatusOr<std::vector<std::string>> ImagesBelow(const std::string& folder, size_t step) {
  std::set<std::string> folders = {folder};
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, error)) {
    if (entry.is_directory()) folders.insert(entry.path());
  }
  if (error) return absl::NotFoundError(absl::StrCat(folder, ": ", error.message()));
  std::vector<std::string> chosen;
  for (const std::string& inner : folders) {
    const auto images = ListImages(inner);
    if (!images.ok()) continue;  // only folders in it
    for (size_t i = 0; i < images->size(); i += step) chosen.push_back((*images)[i]);
  }
  if (chosen.empty()) return absl::NotFoundError(absl::StrCat(folder, ": has no images"));
  return chosen;
}

// "FOLDER" or "FOLDER@STEP".
absl::StatusOr<std::vector<std::string>> ImagesOf(const std::string& argument) {
  const size_t at = argument.rfind('@');
  uint32_t step = 1;
  if (at == std::string::npos) return ImagesBelow(argument, step);
  if (!absl::SimpleAtoi(argument.substr(at + 1), &step) || step == 0) {
    return UsageError(absl::StrCat(argument, ": what follows @ must be a number above 0"));
  }
  return ImagesBelow(argument.substr(0, at), step);
}

std::string StemOf(const std::string& path) { return std::filesystem::path(path).stem(); }

absl::StatusOr<std::vector<std::string>> ChooseImages(const TrainOptions& options) {
  std::set<std::string> held_out;
  for (const std::string& folder : options.held_out) {
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> images, ImagesOf(folder));
    for (const std::string& image : images) held_out.insert(StemOf(image));
  }
  std::vector<std::string> chosen;
  for (const std::string& folder : options.folders) {
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> images, ImagesOf(folder));
    std::copy_if(images.begin(), images.end(), std::back_inserter(chosen),
                 [&](const std::string& image) { return !held_out.contains(StemOf(image)); });
  }
  return chosen;
}

cv::Mat ReadGrey(const std::string& path) {
  try {
    return cv::imread(path, cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {
    return {};
  }
}

std::vector<std::vector<Descriptor>> DescribeImages(const std::vector<std::string>& paths,
                                                    const OrbConfig& orb, const Console& console) {
  OrbExtractor extractor(orb);
  std::vector<std::vector<Descriptor>> images;
  for (const std::string& path : paths) {
    FrameFeatures features;
    extractor.Extract(ReadGrey(path), &features);
    if (features.descriptors.empty()) {
      console.err << path << ": cannot be read, or shows nothing\n";
      continue;
    }
    images.push_back(std::move(features.descriptors));
    if (images.size() % kImagesBetweenReports == 0) {
      console.err << images.size() << " of " << paths.size() << " images\n";
    }
  }
  return images;
}

absl::Status Run(const TrainOptions& options, const Console& console) {
  if (options.training.direct_level > options.training.levels) {
    return UsageError("--direct-level is below the leaves");
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> paths, ChooseImages(options));
  const auto images = DescribeImages(paths, options.orb, console);
  const auto progress = [&console](int level, size_t nodes) {
    console.err << "level " << level << ": " << nodes << " nodes\n";
  };
  SEMMAP_ASSIGN_OR_RETURN(const VocabularyTree tree, TrainVocabulary(images, options.training, progress));
  SEMMAP_RETURN_IF_ERROR(WriteVocabulary(options.output, tree.View()));
  const auto size = static_cast<int64_t>(std::filesystem::file_size(options.output));
  console.out << absl::StrFormat("%s: %d words, %d nodes, from %d images, %s\n", options.output,
                                 tree.idf.size(), tree.nodes.size(), images.size(), FormatBytes(size));
  return absl::OkStatus();
}

}  // namespace

void AddTrainVocabularyCommand(CLI::App& parent, Action* action) {
  CLI::App* command =
      parent.add_subcommand("train-vocabulary", "Learn the words of place recognition from images");
  auto options = std::make_shared<TrainOptions>();
  command
      ->add_option("--images", options->folders,
                   "Folders, searched with all below them; FOLDER@N takes every N-th image")
      ->required();
  command->add_option("--hold-out", options->held_out, "Leave out images named like one in these folders");
  command->add_option("--output", options->output, "File to write")->required();
  command->add_option("--branching", options->training.branching, "Children of a node")
      ->check(CLI::Range(2, 256))
      ->capture_default_str();
  command->add_option("--levels", options->training.levels, "Levels below the root")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  command
      ->add_option("--direct-level", options->training.direct_level,
                   "Level that groups keypoints for matching")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
  command->add_option("--min-descriptors", options->training.min_descriptors, "Smaller nodes are not split")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str();
  command->add_option("--features", options->orb.features, "Keypoints of an image")
      ->check(CLI::Range(100, 10000))
      ->capture_default_str();
  command->add_option("--seed", options->training.seed, "Of all random choices")->capture_default_str();
  command->callback(
      [options, action] { *action = [options](const Console& console) { return Run(*options, console); }; });
}

}  // namespace semmap::client
