// Feature extraction and stereo matching beside cv::ORB on the same images and in the same run: times hold on
// one machine only, ratios travel. Reads SEMMAP_SHARED (or ../shared)/data/sequences; without it a synthetic
// image stands in.
#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slam/features/descriptor_search.h"
#include "slam/features/feature_grid.h"
#include "slam/features/orb_extractor.h"
#include "slam/features/stereo_matcher.h"

namespace semmap {
namespace {

constexpr int kFeatures = 2000;
constexpr double kFocal = 707.09;
constexpr double kBaseline = 0.537;

std::string SequenceFile(const std::string& name) {
  const char* shared = std::getenv("SEMMAP_SHARED");
  return std::string(shared != nullptr ? shared : SEMMAP_SOURCE_DIR "/../shared") + "/data/sequences/" + name;
}

cv::Mat SyntheticImage(const cv::Size& size) {
  cv::RNG random(1);
  cv::Mat image(size, CV_8UC1, cv::Scalar(100));
  for (int i = 0; i < 6000; ++i) {
    const cv::Point corner(random.uniform(0, size.width), random.uniform(0, size.height));
    cv::rectangle(image, cv::Rect(corner, cv::Size(random.uniform(3, 30), random.uniform(3, 30))),
                  cv::Scalar(random.uniform(0, 255)), cv::FILLED);
  }
  cv::GaussianBlur(image, image, {5, 5}, 1.0);
  return image;
}

cv::Mat LoadOr(const std::string& name, const cv::Size& substitute) {
  cv::Mat image = cv::imread(SequenceFile(name), cv::IMREAD_GRAYSCALE);
  return image.empty() ? SyntheticImage(substitute) : image;
}

const cv::Mat& MonoImage() {
  static const cv::Mat image = LoadOr("kitti00_mono200/image_0/000020.png", {1241, 376});
  return image;
}
const cv::Mat& LeftImage() {
  static const cv::Mat image = LoadOr("kitti06_stereo51/image_0/000020.png", {1226, 370});
  return image;
}
const cv::Mat& RightImage() {
  static const cv::Mat image = LoadOr("kitti06_stereo51/image_1/000020.png", {1226, 370});
  return image;
}

OrbConfig Config() {
  OrbConfig config;
  config.features = kFeatures;
  return config;
}

class OpenCvOrb {
 public:
  void Extract(const cv::Mat& image) {
    orb_->detectAndCompute(image, cv::noArray(), keypoints_, descriptors_);
  }

 private:
  cv::Ptr<cv::ORB> orb_ = cv::ORB::create(kFeatures, 1.2F, 8);
  std::vector<cv::KeyPoint> keypoints_;
  cv::Mat descriptors_;
};

struct StereoPair {
  StereoPair() {
    left.Extract(LeftImage(), &left_features);
    right.Extract(RightImage(), &right_features);
  }
  void Match() { matcher.Match(left, right, right_features, &left_features); }

  OrbExtractor left{Config()};
  OrbExtractor right{Config()};
  StereoMatcher matcher{StereoConfig{}, kFocal, kBaseline};
  FrameFeatures left_features;
  FrameFeatures right_features;
};

void BM_OpenCvOrb(benchmark::State& state) {
  cv::setNumThreads(1);
  OpenCvOrb orb;
  for (auto _ : state) orb.Extract(MonoImage());
}
BENCHMARK(BM_OpenCvOrb)->Unit(benchmark::kMillisecond);

void BM_OrbExtractor(benchmark::State& state) {
  OrbExtractor extractor(Config());
  FrameFeatures features;
  for (auto _ : state) extractor.Extract(MonoImage(), &features);
  state.counters["features"] = static_cast<double>(features.size());
}
BENCHMARK(BM_OrbExtractor)->Unit(benchmark::kMillisecond);

void BM_StereoMatcher(benchmark::State& state) {
  StereoPair pair;
  for (auto _ : state) pair.Match();
  const auto& keypoints = pair.left_features.keypoints;
  const auto with_depth =
      std::count_if(keypoints.begin(), keypoints.end(), [](const Keypoint& k) { return k.HasDepth(); });
  state.counters["with_depth"] = static_cast<double>(with_depth);
}
BENCHMARK(BM_StereoMatcher)->Unit(benchmark::kMillisecond);

// Of this thread's CPU time: other processes and throttling do not count.
double CpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

template <typename Function>
double Milliseconds(Function&& function) {
  const double start = CpuMilliseconds();
  function();
  return CpuMilliseconds() - start;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The three in turn, so that whatever else the machine does hits all alike. One unit is a run of cv::ORB.
void BM_InUnits(benchmark::State& state) {
  cv::setNumThreads(1);
  OpenCvOrb orb;
  StereoPair pair;
  FrameFeatures features;
  std::vector<double> unit;
  std::vector<double> extract;
  std::vector<double> stereo;
  for (auto _ : state) {
    unit.push_back(Milliseconds([&] { orb.Extract(LeftImage()); }));
    extract.push_back(Milliseconds([&] { pair.left.Extract(LeftImage(), &pair.left_features); }));
    stereo.push_back(Milliseconds([&] { pair.Match(); }));
  }
  state.counters["unit_ms"] = Median(unit);
  state.counters["extract_units"] = Median(extract) / Median(unit);
  state.counters["stereo_units"] = Median(stereo) / Median(unit);
}
BENCHMARK(BM_InUnits)->Unit(benchmark::kMillisecond)->Iterations(200);

std::vector<Descriptor> RandomDescriptors(size_t count) {
  std::mt19937_64 random(1);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (uint64_t& word : descriptor.words) word = random();
  }
  return descriptors;
}

void BM_NearestTwoOneByOne(benchmark::State& state) {
  const auto descriptors = RandomDescriptors(static_cast<size_t>(state.range(0)));
  const Descriptor query = RandomDescriptors(1)[0];
  for (auto _ : state) {
    int best = NearestTwo::kNoDistance;
    int second = NearestTwo::kNoDistance;
    int index = -1;
    for (size_t i = 0; i < descriptors.size(); ++i) {
      const int distance = HammingDistance(query, descriptors[i]);
      if (distance < best) {
        second = best;
        best = distance;
        index = static_cast<int>(i);
      } else {
        second = std::min(second, distance);
      }
    }
    benchmark::DoNotOptimize(index + second);
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_NearestTwoOneByOne)->Arg(16)->Arg(200)->Arg(2000);

void BM_FindNearestTwo(benchmark::State& state) {
  const auto descriptors = RandomDescriptors(static_cast<size_t>(state.range(0)));
  const Descriptor query = RandomDescriptors(1)[0];
  for (auto _ : state) benchmark::DoNotOptimize(FindNearestTwo(query, descriptors));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_FindNearestTwo)->Arg(16)->Arg(200)->Arg(2000);

void BM_FeatureGrid(benchmark::State& state) {
  OrbExtractor extractor(Config());
  FrameFeatures features;
  extractor.Extract(MonoImage(), &features);
  const ImageBounds bounds{0, 0, static_cast<float>(MonoImage().cols), static_cast<float>(MonoImage().rows)};
  FeatureGrid grid;
  for (auto _ : state) {
    grid.Assign(bounds, features.keypoints);
    int found = 0;
    for (const Keypoint& keypoint : features.keypoints) {
      grid.ForEachInWindow(features.keypoints, keypoint.x, keypoint.y, 15, [&](int) { ++found; });
    }
    benchmark::DoNotOptimize(found);
  }
}
BENCHMARK(BM_FeatureGrid)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace semmap

BENCHMARK_MAIN();
