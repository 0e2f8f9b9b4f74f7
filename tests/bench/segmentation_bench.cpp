// How long a network takes for a frame, and whether sessions that share it gain by going through it together.

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <opencv2/core.hpp>

#include "CLI/CLI.hpp"
#include "absl/strings/str_format.h"
#include "client/sources/file_list.h"
#include "client/sources/source_image.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"
#include "slam/evaluation/statistics.h"
#include "slam/semantics/segmentation_model.h"
#include "slam/semantics/torch/torch_segmenter.h"
#include "tests/bench/bench_main.h"

namespace semmap::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string model;
  std::string images;
  int frames = 50;
  int sessions = 4;
  int keypoints = 1500;
  std::vector<int> threads = {1, 2};
  bool json = false;
};

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Of all threads. Other programs on the machine disturb it less than the wall time.
double CpuMilliseconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto milliseconds = [](const timeval& time) {
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_usec);
  };
  return milliseconds(usage.ru_utime) + milliseconds(usage.ru_stime);
}

absl::StatusOr<std::vector<cv::Mat>> ReadImages(const Options& options, cv::Size network) {
  std::vector<cv::Mat> images;
  if (options.images.empty()) {
    cv::RNG random(1);
    cv::Mat noise(network, CV_8UC3);
    random.fill(noise, cv::RNG::UNIFORM, 0, 256);
    images.push_back(noise);
    return images;
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<std::string> files, client::ListImages(options.images));
  for (const std::string& file : files) {
    if (static_cast<int>(images.size()) == options.frames) break;
    SEMMAP_ASSIGN_OR_RETURN(const client::SourceImage image, client::ReadSourceImage(file, false));
    SEMMAP_ASSIGN_OR_RETURN(images.emplace_back(), client::DecodeColour(image));
  }
  if (images.empty()) return absl::NotFoundError("the folder has no images");
  return images;
}

// Keypoints all over the image; the sum of their classes, so that nothing is left out.
int LookUpKeypoints(const Segmentation& segmentation, int keypoints) {
  int sum = 0;
  for (int i = 0; i < keypoints; ++i) {
    const int x = 7919 * i % segmentation.image().width;
    const int y = 104729 * i % segmentation.image().height;
    sum += segmentation.At(static_cast<float>(x), static_cast<float>(y)).semantic_class;
  }
  return sum;
}

// Frame after frame, as one session alone has it.
absl::StatusOr<nlohmann::json> MeasureFrames(const Options& options, const std::vector<cv::Mat>& images,
                                             const std::string& model, int threads) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Segmenter> segmenter, LoadTorchSegmenter(model, threads));
  std::vector<double> segment_ms;
  std::vector<double> look_up_ms;
  int64_t class_sum = 0;
  const double cpu_before = CpuMilliseconds();
  for (int i = 0; i < options.frames; ++i) {
    const cv::Mat& image = images[static_cast<size_t>(i) % images.size()];
    const auto start = Clock::now();
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<Segmentation> segmented, segmenter->Segment({&image, 1}));
    segment_ms.push_back(MillisecondsSince(start));
    const auto looked = Clock::now();
    class_sum += LookUpKeypoints(segmented.front(), options.keypoints);
    look_up_ms.push_back(MillisecondsSince(looked));
  }
  return nlohmann::json{{"threads", threads},
                        {"median_ms", Percentile(segment_ms, 0.5)},
                        {"p95_ms", Percentile(segment_ms, 0.95)},
                        {"cpu_ms", (CpuMilliseconds() - cpu_before) / options.frames},
                        {"keypoints_ms", Percentile(look_up_ms, 0.5)},
                        {"class_sum", class_sum}};
}

// Sessions that each hand in a frame, wait for it and hand in the next.
absl::StatusOr<nlohmann::json> MeasureSessions(const Options& options, const std::vector<cv::Mat>& images,
                                               const std::string& model, int threads, int max_batch) {
  SEMMAP_ASSIGN_OR_RETURN(std::shared_ptr<Segmenter> segmenter, LoadTorchSegmenter(model, threads));
  SegmentationQueue queue(std::move(segmenter),
                          {.max_batch = max_batch, .max_waiting = 2 * options.sessions});
  const int each = std::max(1, options.frames / options.sessions);
  // Once beforehand: the network has not seen this batch yet.
  const auto drive = [&](int frames) {
    std::vector<std::thread> sessions;
    for (int session = 0; session < options.sessions; ++session) {
      sessions.emplace_back([&, session] {
        for (int i = 0; i < frames; ++i) {
          const auto image = static_cast<size_t>(session * frames + i) % images.size();
          queue.Submit(images[image]).Wait(absl::InfiniteDuration());
        }
      });
    }
    for (std::thread& session : sessions) session.join();
  };
  drive(2);
  const SegmentationQueue::Counts before = queue.counts();
  const double cpu_before = CpuMilliseconds();
  const auto start = Clock::now();
  drive(each);
  const double seconds = 1e-3 * MillisecondsSince(start);
  const SegmentationQueue::Counts after = queue.counts();
  const auto frames = static_cast<double>(after.segmented - before.segmented);
  return nlohmann::json{{"threads", threads},
                        {"max_batch", max_batch},
                        {"sessions", options.sessions},
                        {"frames_per_s", frames / seconds},
                        {"cpu_ms", (CpuMilliseconds() - cpu_before) / frames},
                        {"mean_batch", frames / static_cast<double>(after.batches - before.batches)}};
}

absl::StatusOr<nlohmann::json> Measure(const Options& options) {
  const std::string path = options.model.empty() ? DefaultSegmentationModelPath() : options.model;
  SEMMAP_ASSIGN_OR_RETURN(const SegmentationModel model, SegmentationModel::FromFile(path));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<cv::Mat> images,
                          ReadImages(options, {model.input_width, model.input_height}));
  const cv::Size network = model.NetworkSize(images.front().size());
  nlohmann::json report = {{"model", path},
                           {"image", {images.front().cols, images.front().rows}},
                           {"network", {network.width, network.height}},
                           {"frames", options.frames},
                           {"one", nlohmann::json::array()},
                           {"shared", nlohmann::json::array()}};
  for (const int threads : options.threads) {
    SEMMAP_ASSIGN_OR_RETURN(const nlohmann::json one, MeasureFrames(options, images, path, threads));
    report["one"].push_back(one);
    for (const int max_batch : {1, options.sessions}) {
      SEMMAP_ASSIGN_OR_RETURN(const nlohmann::json shared,
                              MeasureSessions(options, images, path, threads, max_batch));
      report["shared"].push_back(shared);
    }
  }
  return report;
}

std::string Table(const nlohmann::json& report) {
  std::string table = absl::StrFormat("images %d x %d, seen by the network as %d x %d\n",
                                      report["image"][0].get<int>(), report["image"][1].get<int>(),
                                      report["network"][0].get<int>(), report["network"][1].get<int>());
  absl::StrAppendFormat(&table, "\n%-8s %12s %9s %12s %14s\n", "threads", "ms a frame", "p95", "CPU ms",
                        "ms keypoints");
  for (const nlohmann::json& row : report["one"]) {
    absl::StrAppendFormat(&table, "%-8d %12.1f %9.1f %12.1f %14.2f\n", row["threads"].get<int>(),
                          row["median_ms"].get<double>(), row["p95_ms"].get<double>(),
                          row["cpu_ms"].get<double>(), row["keypoints_ms"].get<double>());
  }
  absl::StrAppendFormat(&table, "\n%-8s %9s %10s %11s %11s %12s\n", "threads", "sessions", "max batch",
                        "mean batch", "frames / s", "CPU ms");
  for (const nlohmann::json& row : report["shared"]) {
    absl::StrAppendFormat(&table, "%-8d %9d %10d %11.2f %11.1f %12.1f\n", row["threads"].get<int>(),
                          row["sessions"].get<int>(), row["max_batch"].get<int>(),
                          row["mean_batch"].get<double>(), row["frames_per_s"].get<double>(),
                          row["cpu_ms"].get<double>());
  }
  return table;
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Benchmark of image segmentation: one frame after the other, and sessions that share a network");
  Options options;
  app.add_option("--model", options.model, "Description (YAML) of the network; default: semmap's own");
  app.add_option("--images", options.images, "Folder of images; default: noise of the network's own size")
      ->check(CLI::ExistingDirectory);
  app.add_option("--frames", options.frames, "Of each measurement")->check(CLI::Range(1, 100000));
  app.add_option("--sessions", options.sessions, "That share a network")->check(CLI::Range(1, 64));
  app.add_option("--threads", options.threads, "Numbers of threads to measure; default 1 2")
      ->check(CLI::Range(1, 256));
  app.add_flag("--json", options.json, "Print JSON instead of a table");
  return RunMain(app, "segmentation_bench", argc, argv, [&]() -> absl::Status {
    SEMMAP_ASSIGN_OR_RETURN(const nlohmann::json report, Measure(options));
    std::cout << (options.json ? report.dump(2) + "\n" : Table(report));
    return absl::OkStatus();
  });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
