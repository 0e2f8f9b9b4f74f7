#include "tests/bench/place_bench_scaling.h"

#include <ctime>
#include <limits>
#include <random>

#include "slam/evaluation/statistics.h"
#include "slam/place/place_index.h"

namespace semmap::bench {
namespace {

constexpr size_t kBest = 10;
constexpr int kLoads = 21;
constexpr size_t kDescribed = 200;

// Milliseconds of the CPU that this thread has used: what it costs, however busy the machine is.
double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

std::vector<Descriptor> Perturb(std::vector<Descriptor> descriptors, int flipped_bits, uint64_t seed) {
  std::mt19937_64 random(seed);
  for (Descriptor& descriptor : descriptors) {
    // A random number is good for eight bits' positions.
    for (int i = 0; i < flipped_bits; i += 8) {
      uint64_t positions = random();
      for (int j = i; j < std::min(i + 8, flipped_bits); ++j, positions >>= 8U) {
        descriptor.words[(positions >> 6U) & 3U] ^= uint64_t{1} << (positions & 63U);
      }
    }
  }
  return descriptors;
}

class ScalingRun {
 public:
  ScalingRun(const std::vector<std::vector<Descriptor>>& images,
             const std::shared_ptr<const Vocabulary>& vocabulary, const ScalingOptions& options)
      : images_(images), vocabulary_(*vocabulary), options_(options), index_(vocabulary) {}

  void GrowTo(size_t keyframes) {
    double add_ms = 0;
    const size_t before = index_.size();
    for (size_t i = before; i < keyframes; ++i) {
      BagOfWords words = vocabulary_.Describe(Keyframe(i)).words;
      const double start = CpuMs();
      index_.Add(KeyFrameId(i + 1), std::move(words));
      add_ms += CpuMs() - start;
    }
    row_.keyframes = keyframes;
    row_.add_ms = add_ms / static_cast<double>(keyframes - before);
  }

  ScalingRow Measure() {
    // Bounds so wide that they never bind.
    PlaceQueryLimits none;
    none.max_postings = std::numeric_limits<int64_t>::max();
    const Timing bounded = TimeQueries();
    index_.SetLimits(none);
    const Timing exact = TimeQueries();
    index_.SetLimits({});
    row_.median_ms = Percentile(bounded.ms, 0.5);
    row_.p95_ms = Percentile(bounded.ms, 0.95);
    row_.exact_median_ms = Percentile(exact.ms, 0.5);
    row_.found = bounded.found;
    row_.exact_found = exact.found;
    row_.bytes_per_keyframe = static_cast<double>(index_.MemoryBytes()) / static_cast<double>(row_.keyframes);
    return row_;
  }

 private:
  struct Timing {
    std::vector<double> ms;
    double found = 0;
  };

  std::vector<Descriptor> Keyframe(size_t i) const {
    return Perturb(images_[i % images_.size()], options_.flipped_bits, options_.seed + i);
  }

  Timing TimeQueries() const {
    Timing timing;
    for (size_t i = 0; i < options_.queries; ++i) {
      const size_t target = i * index_.size() / options_.queries;
      const BagOfWords query =
          vocabulary_.Describe(Perturb(Keyframe(target), options_.flipped_bits, ~(options_.seed + i))).words;
      const double start = CpuMs();
      const std::vector<PlaceMatch> matches = index_.Query(query, kBest);
      timing.ms.push_back(CpuMs() - start);
      if (!matches.empty() && matches[0].keyframe == KeyFrameId(target + 1)) timing.found += 1;
    }
    timing.found /= static_cast<double>(options_.queries);
    return timing;
  }

  const std::vector<std::vector<Descriptor>>& images_;
  const Vocabulary& vocabulary_;
  const ScalingOptions& options_;
  PlaceIndex index_;
  ScalingRow row_;
};

}  // namespace

double MeasureLoad(const std::string& vocabulary_path) {
  std::vector<double> ms;
  for (int i = 0; i < kLoads; ++i) {
    const double start = CpuMs();
    const auto vocabulary = Vocabulary::Load(vocabulary_path);
    ms.push_back(CpuMs() - start);
  }
  return Percentile(ms, 0.5);
}

ScalingResult MeasureScaling(const std::vector<std::vector<Descriptor>>& images,
                             const std::shared_ptr<const Vocabulary>& vocabulary,
                             const ScalingOptions& options) {
  ScalingResult result;
  std::vector<double> describe_ms;
  for (size_t i = 0; i < kDescribed; ++i) {
    const std::vector<Descriptor>& image = images[i % images.size()];
    const double start = CpuMs();
    const PlaceDescription place = vocabulary->Describe(image);
    describe_ms.push_back(CpuMs() - start);
    result.descriptors += static_cast<double>(image.size()) / kDescribed;
  }
  result.describe_ms = Percentile(describe_ms, 0.5);
  ScalingRun run(images, vocabulary, options);
  for (const size_t size : options.sizes) {
    run.GrowTo(size);
    result.rows.push_back(run.Measure());
  }
  return result;
}

}  // namespace semmap::bench
