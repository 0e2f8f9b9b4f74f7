// Maps two stretches of a recording that overlap, each as a map of its own, joins the maps, and says how well
// they fit: against the truth, before and after.

#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_format.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/ate.h"
#include "slam/pipeline/frame_builder.h"
#include "slam/pipeline/map_joiner.h"
#include "slam/pipeline/map_overlap.h"
#include "slam/pipeline/session.h"
#include "storage/joined_map_loader.h"
#include "storage/map_store.h"
#include "tests/bench/bench_main.h"
#include "tests/bench/slam_bench_run.h"
#include "tests/support/temporary_directory.h"

namespace semmap::bench {
namespace {

constexpr size_t kMaxBytes = size_t{4} << 30;

// Frames [begin, end) of the recording.
struct Stretch {
  uint64_t begin = 0;
  uint64_t end = 0;
};

struct Arguments {
  BenchOptions bench;
  std::string config_file;
  std::vector<uint64_t> first = {0, 121};
  std::vector<uint64_t> second = {80, 200};
};

// Applies a session's deltas to the store.
class StoreSink : public MapDeltaSink {
 public:
  StoreSink(storage::MapStore* store, storage::MapId map, storage::SessionId session)
      : store_(store), map_(map), session_(session) {}
  void OnDelta(MapDelta delta) override {
    if (status_.ok()) status_ = store_->Apply(map_, session_, delta);
  }
  const absl::Status& status() const { return status_; }

 private:
  storage::MapStore* store_;
  storage::MapId map_;
  storage::SessionId session_;
  absl::Status status_;
};

class MergeBench {
 public:
  explicit MergeBench(const Arguments& arguments) : arguments_(arguments) {}

  absl::Status Run() {
    storage::StorageConfig config;
    config.uri = directory_.database_uri();
    SEMMAP_ASSIGN_OR_RETURN(store_, storage::OpenMapStore(config));
    SEMMAP_ASSIGN_OR_RETURN(vocabulary_, LoadVocabulary(arguments_.bench.config.place));
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapId first,
                            MapStretch("first", {arguments_.first[0], arguments_.first[1]}));
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapId second,
                            MapStretch("second", {arguments_.second[0], arguments_.second[1]}));
    SEMMAP_ASSIGN_OR_RETURN(const AteResult first_ate, Evaluate("first", first));
    SEMMAP_ASSIGN_OR_RETURN(const AteResult second_ate, Evaluate("second", second));
    const Sim3 truth = first_ate.reference_from_estimate.Inverse() * second_ate.reference_from_estimate;
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapId joined, Join(first, second, truth));
    return Evaluate("joined", joined).status();
  }

 private:
  using Clock = std::chrono::steady_clock;

  Alignment alignment() const {
    return rig_.sensor == SensorType::kMono ? Alignment::kSim3 : Alignment::kSe3;
  }

  absl::StatusOr<storage::MapId> MapStretch(const std::string& name, const Stretch& stretch) {
    SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<client::FrameSource> source,
                            client::OpenSource(arguments_.bench.source, arguments_.bench.source_options));
    if (!source->ground_truth()) return absl::InvalidArgumentError("the recording has no ground truth");
    truth_ = *source->ground_truth();
    rig_ = source->rig();
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map,
                            store_->CreateMap({name, 1, rig_, rig_.sensor != SensorType::kMono}));
    SEMMAP_ASSIGN_OR_RETURN(const storage::SessionInfo session,
                            store_->StartSession({map.id, "drive-" + name, "bench", 1, rig_}));
    StoreSink sink(store_.get(), map.id, session.id);
    const std::unique_ptr<Executor> executor = MakeThreadPool(1);
    SEMMAP_ASSIGN_OR_RETURN(
        const std::unique_ptr<Session> slam,
        Session::Create(arguments_.bench.config, rig_, &sink, executor.get(), vocabulary_));
    SEMMAP_RETURN_IF_ERROR(Play(stretch, *source, *slam));
    SEMMAP_RETURN_IF_ERROR(sink.status());
    return map.id;
  }

  static absl::Status Play(const Stretch& stretch, client::FrameSource& source, Session& slam) {
    for (uint64_t i = 0; i < stretch.end; ++i) {
      SEMMAP_ASSIGN_OR_RETURN(const std::optional<client::SourceFrame> frame, source.Next());
      if (!frame) break;
      if (i < stretch.begin) continue;
      SEMMAP_ASSIGN_OR_RETURN(const FrameInput input, DecodeFrame(*frame));
      slam.WaitForMapper(0);
      SEMMAP_RETURN_IF_ERROR(slam.Track(input).status());
    }
    slam.Finish();
    return absl::OkStatus();
  }

  // All frames of a map against the truth, in one alignment.
  absl::StatusOr<AteResult> Evaluate(const char* name, storage::MapId map) {
    std::map<storage::SessionId, Trajectory> drives;
    SEMMAP_RETURN_IF_ERROR(store_->ForEachTrajectoryPose(map, {}, [&](const storage::TrajectoryPose& pose) {
      drives[pose.session].poses.push_back({pose.timestamp, pose.map_from_camera});
      return true;
    }));
    std::vector<PosePair> pairs;
    for (const auto& [session, drive] : drives) {
      SEMMAP_ASSIGN_OR_RETURN(const std::vector<PosePair> of_drive, AssociateByTime(truth_, drive));
      pairs.insert(pairs.end(), of_drive.begin(), of_drive.end());
    }
    SEMMAP_ASSIGN_OR_RETURN(const AteResult ate, ComputeAte(pairs, alignment()));
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo info, store_->GetMap(map));
    std::cout << absl::StrFormat("%-7s %4d frames, %3d keyframes, %5d points, ATE %.3f m\n", name,
                                 pairs.size(), info.keyframe_count, info.point_count, ate.translation_m.rmse);
    return ate;
  }

  void ReportSimilarity(const MapOverlap& overlap, const Sim3& truth) const {
    const Sim3& found = overlap.target_from_source;
    const SE3 difference = truth.rigid.Inverse() * found.rigid;
    std::cout << absl::StrFormat(
        "overlap %d of %d keyframes found, %d agree, %d rivals\n"
        "moved by %.3f %.3f %.3f, scaled by %.4f; truth %.3f %.3f %.3f, scaled by %.4f; %.2f degrees apart\n",
        overlap.found, overlap.keyframes, overlap.links.size(), overlap.rivals, found.rigid.translation().x(),
        found.rigid.translation().y(), found.rigid.translation().z(), found.scale,
        truth.rigid.translation().x(), truth.rigid.translation().y(), truth.rigid.translation().z(),
        truth.scale, difference.RotationAngle() * 180 / std::numbers::pi);
  }

  absl::StatusOr<storage::MapId> Join(storage::MapId first, storage::MapId second, const Sim3& truth) {
    const SlamConfig& config = arguments_.bench.config;
    const auto start = Clock::now();
    SEMMAP_ASSIGN_OR_RETURN(
        storage::JoinedMaps maps,
        storage::LoadJoinedMaps(*store_, first, second,
                                ScalePyramidInfo(config.orb.levels, config.orb.scale_factor), kMaxBytes,
                                config.semantics.PointPolicy(), false));
    PlaceMemory places(vocabulary_, config.place.query, config.semantics.InactiveClasses());
    for (const auto& [id, keyframe] : maps.map.keyframes()) places.Add(keyframe);
    const MappingCamera camera = MakeMappingCamera(config, FrameBuilder(config, rig_, nullptr));
    const KeyFrameId last = maps.target.last_keyframe_id;
    SEMMAP_ASSIGN_OR_RETURN(const MapOverlap overlap,
                            FindOverlap(config, camera, places, maps.map, last, nullptr));
    ReportSimilarity(overlap, truth);
    if (!overlap.IsSound(config.merge)) return absl::FailedPreconditionError("the maps do not overlap");
    const bool mono = rig_.sensor == SensorType::kMono;
    MapJoiner joiner(config, camera, overlap, last, mono, &maps.map);
    joiner.Align(nullptr);
    const int fused = joiner.Fuse(nullptr);
    const double before = joiner.MeasureSeam().rms_px;
    joiner.Adjust(nullptr);
    storage::MapRewrite rewrite;
    rewrite.map = {first, maps.target.version};
    rewrite.joined = storage::MapRewrite::Basis{second, maps.source.version};
    rewrite.changes = maps.map.TakeDelta();
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo joined, store_->RewriteMap(rewrite, nullptr));
    SEMMAP_ASSIGN_OR_RETURN(const auto findings, store_->CheckIntegrity(joined.id, 10));
    std::cout << absl::StrFormat(
        "fused %d points, residual %.2f px, %.2f before adjustment, %d problems, %.1f s\n", fused,
        joiner.MeasureSeam().rms_px, before, findings.size(),
        std::chrono::duration<double>(Clock::now() - start).count());
    return joined.id;
  }

  const Arguments& arguments_;
  TemporaryDirectory directory_;
  std::unique_ptr<storage::MapStore> store_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  Trajectory truth_;
  CameraRig rig_;
};

void AddOptions(CLI::App* app, Arguments* arguments) {
  static const std::map<std::string, SensorType> sensors = {
      {"mono", SensorType::kMono}, {"stereo", SensorType::kStereo}, {"rgbd", SensorType::kRgbd}};
  app->add_option("--source", arguments->bench.source, client::SourceSpecHelp())->required();
  app->add_option("--sensor", arguments->bench.source_options.sensor, "mono|stereo|rgbd")
      ->required()
      ->transform(CLI::CheckedTransformer(sensors));
  app->add_option("--config", arguments->config_file, "File whose `slam` section is used");
  app->add_option("--first", arguments->first, "Frames of the first map: begin and end")->expected(2);
  app->add_option("--second", arguments->second, "Frames of the second map: begin and end")->expected(2);
}

absl::Status RunWith(Arguments* arguments) {
  if (!arguments->config_file.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(arguments->bench.config, SlamConfig::FromFile(arguments->config_file));
  }
  return MergeBench(*arguments).Run();
}

int Main(int argc, char** argv) {
  CLI::App app("Benchmark of joining the maps of two stretches of a recording");
  Arguments arguments;
  AddOptions(&app, &arguments);
  return RunMain(app, "map_merge_bench", argc, argv, [&arguments] { return RunWith(&arguments); });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
