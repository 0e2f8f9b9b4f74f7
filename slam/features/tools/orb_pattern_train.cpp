// Learns the comparisons of the BRIEF descriptor from images and writes them as a table for orb_pattern.cpp.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slam/features/tools/patch_sampler.h"
#include "slam/features/tools/pattern_selection.h"

namespace semmap {
namespace {

struct Options {
  std::vector<std::string> folders;
  std::string output;
  std::string data_name;
  int patches_per_image = 25;
  PatternSelectionConfig selection;
};

std::vector<std::string> ImagesIn(const std::vector<std::string>& folders) {
  std::vector<std::string> images;
  for (const std::string& folder : folders) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      const std::string extension = entry.path().extension();
      if (extension == ".jpg" || extension == ".png") images.push_back(entry.path());
    }
  }
  std::sort(images.begin(), images.end());
  return images;
}

bool WritePattern(const Options& options, const PatternSelection& selection, size_t patches) {
  std::ofstream file(options.output);
  file << "// Comparisons {x1, y1, x2, y2} of the BRIEF descriptor, learnt by orb_pattern_train from "
       << patches << " oriented patches\n// of " << options.data_name
       << ",\n// patches per image: " << options.patches_per_image
       << ", candidates: " << options.selection.candidates << ", seed: " << options.selection.seed
       << ", instability weight: " << options.selection.instability_weight
       << ".\n// Greatest correlation of two: " << selection.max_correlation
       << "; bits that differ between two sights of a patch: " << selection.mean_instability
       << ".\n// clang-format off\n";
  for (const BriefTest& test : selection.pattern) {
    file << "{" << int{test.x1} << ", " << int{test.y1} << ", " << int{test.x2} << ", " << int{test.y2}
         << "},\n";
  }
  file << "// clang-format on\n";
  return file.good();
}

int Train(const Options& options) {
  PatchSampler sampler(options.patches_per_image, options.selection.seed);
  for (const std::string& path : ImagesIn(options.folders)) {
    const cv::Mat grey = cv::imread(path, cv::IMREAD_GRAYSCALE);
    if (!grey.empty()) sampler.Add(grey);
  }
  const size_t patches = sampler.samples().original[0].size();
  if (patches < 1000) {
    std::fprintf(stderr, "too few images: only %zu patches\n", patches);
    return 1;
  }
  const PatternSelection selection = SelectPattern(sampler.samples(), options.selection);
  std::printf("%zu patches, correlation up to %.2f, %.4f of the bits unstable\n", patches,
              selection.max_correlation, selection.mean_instability);
  return WritePattern(options, selection, patches) ? 0 : 1;
}

}  // namespace
}  // namespace semmap

int main(int argc, char** argv) {
  semmap::Options options;
  CLI::App app("Learns the comparisons of the BRIEF descriptor");
  app.add_option("folders", options.folders, "Folders of images, searched recursively")->required();
  app.add_option("--output", options.output, "The table to write")->required();
  app.add_option("--data-name", options.data_name, "What to call the data in the table's comment")
      ->required();
  app.add_option("--patches-per-image", options.patches_per_image)->check(CLI::Range(1, 1000));
  app.add_option("--candidates", options.selection.candidates)->check(CLI::Range(1000, 400000));
  app.add_option("--seed", options.selection.seed);
  app.add_option("--instability-weight", options.selection.instability_weight)->check(CLI::Range(0.0, 10.0));
  CLI11_PARSE(app, argc, argv);
  return semmap::Train(options);
}
