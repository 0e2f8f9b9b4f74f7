// semmap eval segmentation: how well a network knows the classes of labelled images, as the service runs it.

#include <memory>

#include "client/cli/commands.h"
#include "client/cli/eval_segmentation.h"
#include "slam/common/status_macros.h"
#include "slam/semantics/segmentation_model.h"
#include "slam/semantics/torch/torch_segmenter.h"

namespace semmap::client {
namespace {

absl::Status Run(const SegmentationEvalOptions& options, const Console& console) {
  const std::string model = options.model.empty() ? DefaultSegmentationModelPath() : options.model;
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Segmenter> segmenter,
                          LoadTorchSegmenter(model, options.threads));
  SEMMAP_ASSIGN_OR_RETURN(const SegmentationEval eval, EvaluateSegmentation(options, segmenter.get()));
  console.out << (options.json ? SegmentationJson(eval).dump(2) + "\n" : SegmentationTable(eval));
  return absl::OkStatus();
}

}  // namespace

void AddEvalSegmentationCommand(CLI::App& eval_command, Action* action) {
  CLI::App* command = eval_command.add_subcommand(
      "segmentation", "Intersection over union and accuracy of a network's classes");
  auto options = std::make_shared<SegmentationEvalOptions>();
  command->add_option("--model", options->model, "Description (YAML) of the network; default: semmap's own");
  command->add_option("--images", options->images, "Folder of images")
      ->required()
      ->check(CLI::ExistingDirectory);
  command->add_option("--labels", options->labels, "Folder of class masks, named like the images")
      ->required()
      ->check(CLI::ExistingDirectory);
  command->add_option("--list", options->list, "Take only the images that this file names, one a line")
      ->check(CLI::ExistingFile);
  command
      ->add_option("--merge", options->merge,
                   "Classes that the labels do not tell apart: none, carla (0.8) or camvid11")
      ->check(CLI::IsMember({"none", "carla", "camvid11"}));
  command->add_option("--threads", options->threads, "Of the network; 0: one for each core")
      ->check(CLI::Range(0, 256));
  command->add_option("--every", options->every, "Only every n-th image")->check(CLI::PositiveNumber);
  command->add_flag("--json", options->json, "Print JSON");
  command->callback(
      [options, action] { *action = [options](const Console& console) { return Run(*options, console); }; });
}

}  // namespace semmap::client
