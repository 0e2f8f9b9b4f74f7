// How fast the store takes what a drive produces and answers what an operator asks, and how large it grows.
// The directory of the database is $SEMMAP_BENCH_DIR, else the system's temporary one.
#include <benchmark/benchmark.h>
#include <sqlite3.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "storage/map_store.h"

namespace semmap::storage {
namespace {

constexpr size_t kKeypoints = 2000;
constexpr size_t kNewPoints = 300;
constexpr size_t kChangedPoints = 1500;
constexpr size_t kLocalKeyFrames = 20;
// Metres between keyframes.
constexpr double kStep = 1.5;

[[noreturn]] void Fail(const absl::Status& status) {
  std::fprintf(stderr, "storage_bench: %s\n", status.ToString().c_str());
  std::exit(1);
}

void Check(const absl::Status& status) {
  if (!status.ok()) Fail(status);
}

// A store in a directory of its own, with one map and one session.
class BenchStore {
 public:
  explicit BenchStore(const std::string& synchronous = "normal") {
    const char* base = std::getenv("SEMMAP_BENCH_DIR");
    const std::filesystem::path parent = base == nullptr ? std::filesystem::temp_directory_path() : base;
    directory_ = parent / ("semmap_storage_bench_" + std::to_string(getpid()));
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
    config_.uri = "sqlite://" + path();
    config_.synchronous = synchronous;
    Reopen();
    NewMap map{"bench", 0, {}, true};
    map.rig.camera = {1241, 376, 718.856, 718.856, 607, 185, DistortionModel::kNone, {}};
    const absl::StatusOr<MapInfo> created = store_->CreateMap(map);
    if (!created.ok()) Fail(created.status());
    map_ = created->id;
    const absl::StatusOr<SessionInfo> session = store_->StartSession({map_, "bench", "bench", 0, map.rig});
    if (!session.ok()) Fail(session.status());
    session_ = session->id;
  }
  ~BenchStore() {
    store_.reset();
    std::filesystem::remove_all(directory_);
  }
  BenchStore(const BenchStore&) = delete;
  BenchStore& operator=(const BenchStore&) = delete;

  void Reopen() {
    store_.reset();
    absl::StatusOr<std::unique_ptr<MapStore>> store = OpenMapStore(config_);
    if (!store.ok()) Fail(store.status());
    store_ = *std::move(store);
  }

  std::string path() const { return (directory_ / "maps.db").string(); }
  MapStore& store() { return *store_; }
  MapId map() const { return map_; }
  SessionId session() const { return session_; }

 private:
  std::filesystem::path directory_;
  StorageConfig config_;
  std::unique_ptr<MapStore> store_;
  MapId map_;
  SessionId session_;
};

// A drive along x: what the mapper tells after each keyframe.
class Drive {
 public:
  MapDelta Next() {
    MapDelta delta;
    delta.version = ++version_;
    AddKeyFrame(&delta);
    for (size_t i = 0; i < kNewPoints; ++i) delta.upserted_points.push_back(NewPoint());
    ChangePoints(&delta);
    MoveKeyFrames(&delta);
    for (uint64_t i = 0; i < 5; ++i) {
      const uint64_t sequence = 5 * version_ + i;
      delta.frames.push_back({sequence, static_cast<TimestampNs>(sequence), KeyFrameId(version_), SE3()});
    }
    return delta;
  }

 private:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  float UniformFloat(double high) { return static_cast<float>(Uniform(0, high)); }

  void AddKeyFrame(MapDelta* delta) {
    auto features = std::make_shared<FrameFeatures>();
    for (size_t i = 0; i < kKeypoints; ++i) {
      const bool deep = i % 10 < 6;
      features->keypoints.push_back({UniformFloat(1241), UniformFloat(376), deep ? UniformFloat(1241) : -1.0F,
                                     deep ? UniformFloat(80) : -1.0F, UniformFloat(6.28),
                                     static_cast<uint8_t>(i % 8), static_cast<uint8_t>(random_() % 23)});
      features->descriptors.push_back({{random_(), random_(), random_(), random_()}});
    }
    KeyFrameRecord keyframe;
    keyframe.id = KeyFrameId(version_);
    keyframe.sequence = 5 * version_;
    keyframe.parent = KeyFrameId(version_ - 1);
    keyframe.map_from_camera =
        SE3(Eigen::Quaterniond::Identity(), {kStep * static_cast<double>(version_), 0, 0});
    keyframe.features = std::move(features);
    delta->added_keyframes.push_back(std::move(keyframe));
  }

  MapPointRecord NewPoint() {
    MapPointRecord point;
    point.id = MapPointId(++last_point_);
    point.position_in_map = {kStep * static_cast<double>(version_) + Uniform(2, 60), Uniform(-20, 20),
                             Uniform(-2, 6)};
    point.descriptor.words = {random_(), random_(), random_(), random_()};
    point.reference_keyframe = KeyFrameId(version_);
    point.votes = {{7, 3}, {8, 1}};
    point.semantic_class = 7;
    points_.push_back(point);
    return point;
  }

  // Bundle adjustment of the neighbourhood: every point a centimetre.
  void ChangePoints(MapDelta* delta) {
    const size_t local = std::min<size_t>(points_.size() - kNewPoints, 4 * kChangedPoints);
    const size_t first = points_.size() - kNewPoints - local;
    for (size_t i = 0; i < std::min(local, kChangedPoints); ++i) {
      MapPointRecord& point = points_[first + random_() % local];
      point.position_in_map +=
          Eigen::Vector3d(Uniform(-0.01, 0.01), Uniform(-0.01, 0.01), Uniform(-0.01, 0.01));
      ++point.observation_count;
      delta->upserted_points.push_back(point);
    }
    // As the map tells them.
    std::sort(delta->upserted_points.begin(), delta->upserted_points.end(),
              [](const MapPointRecord& a, const MapPointRecord& b) { return a.id < b.id; });
  }

  void MoveKeyFrames(MapDelta* delta) {
    const uint64_t first = version_ > kLocalKeyFrames ? version_ - kLocalKeyFrames + 1 : 1;
    for (uint64_t id = first; id <= version_; ++id) {
      KeyFrameObservations observations{KeyFrameId(id), std::vector<MapPointId>(kKeypoints)};
      for (size_t i = 0; i < kKeypoints; i += 1 + random_() % 5) {
        observations.point_of_keypoint[i] =
            points_[points_.size() - 1 - random_() % std::min<size_t>(points_.size(), 5000)].id;
      }
      delta->observations.push_back(std::move(observations));
      if (id == version_) continue;
      const double x = kStep * static_cast<double>(id) + Uniform(-0.01, 0.01);
      delta->moved_keyframes.push_back(
          {KeyFrameId(id), SE3(Eigen::Quaterniond::Identity(), {x, 0, 0}), KeyFrameId(id - 1)});
    }
  }

  std::mt19937_64 random_{42};
  std::vector<MapPointRecord> points_;
  uint64_t version_ = 0;
  uint64_t last_point_ = 0;
};

// What this thread computed, whoever else has the machine: comparable where wall time is not.
double ThreadCpuMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double Quantile(std::vector<double>* values, double q) {
  std::sort(values->begin(), values->end());
  return values->at(static_cast<size_t>(q * static_cast<double>(values->size() - 1)));
}

// Pages of the file that belong to tables and indexes whose name begins so.
double BytesOf(const std::string& path, const std::string& prefix) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  sqlite3_stmt* statement = nullptr;
  const std::string sql = "SELECT sum(pgsize) FROM dbstat WHERE name LIKE '" + prefix +
                          "%' OR name LIKE 'sqlite_autoindex_" + prefix + "%'";
  sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr);
  const double bytes = sqlite3_step(statement) == SQLITE_ROW ? sqlite3_column_double(statement, 0) : -1;
  sqlite3_finalize(statement);
  sqlite3_close(database);
  return bytes;
}

void ReportSizes(const BenchStore& bench, double keyframes, benchmark::State* state) {
  const double points = keyframes * kNewPoints;
  state->counters["feature_B_per_kf"] = BytesOf(bench.path(), "keyframe_features") / keyframes;
  state->counters["observation_B_per_kf"] = BytesOf(bench.path(), "keyframe_observations") / keyframes;
  state->counters["point_row_B"] =
      (BytesOf(bench.path(), "points") - BytesOf(bench.path(), "points_by_cell")) / points;
  state->counters["point_index_B"] =
      BytesOf(bench.path(), "point_cells") / points + BytesOf(bench.path(), "points_by_cell") / points;
  state->counters["file_B_per_kf"] =
      static_cast<double>(std::filesystem::file_size(bench.path())) / keyframes;
}

// One keyframe of 2000 keypoints, 300 new points, 1500 changed ones, 20 rewritten observation rows.
void BM_ApplyStep(benchmark::State& state, const std::string& synchronous) {
  BenchStore bench(synchronous);
  Drive drive;
  for (int i = 0; i < 25; ++i) Check(bench.store().Apply(bench.map(), bench.session(), drive.Next()));
  std::vector<double> times_ms;
  std::vector<double> cpu_ms;
  double keyframes = 25;
  for (auto unused : state) {
    (void)unused;
    const MapDelta delta = drive.Next();
    const double cpu_start = ThreadCpuMs();
    const auto start = std::chrono::steady_clock::now();
    Check(bench.store().Apply(bench.map(), bench.session(), delta));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    cpu_ms.push_back(ThreadCpuMs() - cpu_start);
    state.SetIterationTime(taken.count());
    times_ms.push_back(1e3 * taken.count());
    ++keyframes;
  }
  state.counters["median_ms"] = Quantile(&times_ms, 0.5);
  state.counters["cpu_median_ms"] = Quantile(&cpu_ms, 0.5);
  state.counters["p95_ms"] = Quantile(&times_ms, 0.95);
  state.counters["max_ms"] = Quantile(&times_ms, 1);
  bench.Reopen();  // empties the log into the file
  ReportSizes(bench, keyframes, &state);
}
BENCHMARK_CAPTURE(BM_ApplyStep, normal, "normal")
    ->UseManualTime()
    ->Iterations(300)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_ApplyStep, full, "full")
    ->UseManualTime()
    ->Iterations(100)
    ->Unit(benchmark::kMillisecond);

// 1,000,000 points spread evenly over 1000 m x 1000 m x 10 m, in the order of a drive that covers it in
// lanes.
class MillionPoints {
 public:
  static MillionPoints& Instance() {
    static MillionPoints instance;
    return instance;
  }
  BenchStore& bench() { return bench_; }

 private:
  MillionPoints() {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    constexpr size_t kSteps = 10000;
    constexpr size_t kPointsPerStep = 100;
    for (size_t step = 0; step < kSteps; ++step) {
      MapDelta delta;
      delta.version = step + 1;
      const double x = 10.0 * static_cast<double>(step % 100);
      const double y = 10.0 * static_cast<double>(step / 100);
      KeyFrameRecord keyframe;
      keyframe.id = KeyFrameId(step + 1);
      keyframe.map_from_camera = SE3(Eigen::Quaterniond::Identity(), {x, y, 0});
      keyframe.features = std::make_shared<FrameFeatures>();
      delta.added_keyframes.push_back(keyframe);
      for (size_t i = 0; i < kPointsPerStep; ++i) {
        MapPointRecord point;
        point.id = MapPointId(step * kPointsPerStep + i + 1);
        point.position_in_map = {x + 10 * unit(random), y + 10 * unit(random), 10 * unit(random)};
        point.reference_keyframe = keyframe.id;
        point.semantic_class = static_cast<uint8_t>(random() % 23);
        point.votes = {{point.semantic_class, 1}};
        delta.upserted_points.push_back(point);
      }
      Check(bench_.store().Apply(bench_.map(), bench_.session(), delta));
    }
    bench_.Reopen();
  }

  BenchStore bench_;
};

// 100 m x 100 m: about 10,000 points, the result's 1 percent of the map, somewhere else each time.
void BM_BoxQuery(benchmark::State& state) {
  BenchStore& bench = MillionPoints::Instance().bench();
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> corner(0, 900);
  std::vector<double> times_ms;
  size_t found = 0;
  for (auto unused : state) {
    (void)unused;
    const Eigen::Vector3d low(corner(random), corner(random), -1);
    MapPointQuery query;
    query.box = Eigen::AlignedBox3d(low, low + Eigen::Vector3d(100, 100, 20));
    const auto start = std::chrono::steady_clock::now();
    Check(bench.store().ForEachMapPoint(bench.map(), query, [&](const MapPointRecord&) {
      ++found;
      return true;
    }));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(taken.count());
    times_ms.push_back(1e3 * taken.count());
  }
  state.counters["points"] = static_cast<double>(found) / static_cast<double>(times_ms.size());
  state.counters["median_ms"] = Quantile(&times_ms, 0.5);
  state.counters["p95_ms"] = Quantile(&times_ms, 0.95);
}
BENCHMARK(BM_BoxQuery)->UseManualTime()->Iterations(100)->Unit(benchmark::kMillisecond);

void BM_GetMap(benchmark::State& state) {
  BenchStore& bench = MillionPoints::Instance().bench();
  for (auto unused : state) {
    (void)unused;
    const absl::StatusOr<MapInfo> map = bench.store().GetMap(bench.map());
    if (!map.ok() || map->keyframe_count != 10000) Fail(map.status());
  }
}
BENCHMARK(BM_GetMap)->Unit(benchmark::kMillisecond);

void BM_Summarize(benchmark::State& state) {
  BenchStore& bench = MillionPoints::Instance().bench();
  for (auto unused : state) {
    (void)unused;
    const absl::StatusOr<MapSummary> summary = bench.store().Summarize(bench.map());
    if (!summary.ok()) Fail(summary.status());
  }
}
BENCHMARK(BM_Summarize)->Iterations(3)->Unit(benchmark::kMillisecond);

void BM_CheckIntegrity(benchmark::State& state) {
  BenchStore& bench = MillionPoints::Instance().bench();
  for (auto unused : state) {
    (void)unused;
    const absl::StatusOr<std::vector<IntegrityFinding>> findings =
        bench.store().CheckIntegrity(bench.map(), 3);
    if (!findings.ok()) Fail(findings.status());
  }
}
BENCHMARK(BM_CheckIntegrity)->Iterations(1)->Unit(benchmark::kMillisecond);

void BM_Open(benchmark::State& state) {
  BenchStore& bench = MillionPoints::Instance().bench();
  for (auto unused : state) {
    (void)unused;
    bench.Reopen();
  }
}
BENCHMARK(BM_Open)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace semmap::storage

BENCHMARK_MAIN();
