#include "tests/bench/map_scale/map_scale_drive.h"

#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "client/sources/open_source.h"
#include "client/town/drive.h"
#include "slam/common/status_macros.h"
#include "slam/pipeline/session.h"
#include "slam/place/vocabulary.h"
#include "storage/map_store.h"
#include "tests/bench/slam_bench_run.h"

namespace semmap::bench {
namespace {

// Frames that are kept as pictures: one in so many.
constexpr uint64_t kFramesPerQuery = 3;

// The frames of a drive, one after the other.
struct Frames {
  CameraRig rig;
  std::function<absl::StatusOr<std::optional<FrameInput>>()> next;
};

absl::StatusOr<Frames> OpenTown(const std::string& route, const MapScaleOptions& options) {
  town::DriveConfig config;
  config.route = route;
  config.traffic = {};
  config.stereo = options.sensor == SensorType::kStereo;
  config.rig.frames_per_second = 10;
  SEMMAP_ASSIGN_OR_RETURN(std::shared_ptr<town::TownDrive> drive, town::TownDrive::Create(config));
  Frames frames;
  frames.rig.sensor = options.sensor;
  frames.rig.camera = config.rig.Intrinsics();
  if (config.stereo) frames.rig.baseline_m = config.rig.baseline_m;
  frames.rig.frames_per_second = config.rig.frames_per_second;
  frames.rig.body_from_camera = config.rig.VehicleFromCamera();
  frames.next = [drive]() -> absl::StatusOr<std::optional<FrameInput>> {
    town::DriveFrame seen;
    SEMMAP_ASSIGN_OR_RETURN(const bool more, drive->Next(&seen));
    if (!more) return std::optional<FrameInput>();
    FrameInput input;
    input.sequence = static_cast<uint64_t>(seen.index) + 1;
    input.timestamp = seen.timestamp_ns;
    cv::cvtColor(seen.left.rgb, input.image, cv::COLOR_RGB2GRAY);
    if (!seen.right_rgb.empty()) cv::cvtColor(seen.right_rgb, input.right, cv::COLOR_RGB2GRAY);
    return std::optional<FrameInput>(std::move(input));
  };
  return frames;
}

absl::StatusOr<Frames> OpenRecording(const MapScaleOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(std::shared_ptr<client::FrameSource> source,
                          client::OpenSource(options.source, {options.sensor, "", false}));
  Frames frames;
  frames.rig = source->rig();
  frames.next = [source]() -> absl::StatusOr<std::optional<FrameInput>> {
    SEMMAP_ASSIGN_OR_RETURN(const auto frame, source->Next());
    if (!frame) return std::optional<FrameInput>();
    SEMMAP_ASSIGN_OR_RETURN(FrameInput input, DecodeFrame(*frame));
    return std::optional<FrameInput>(std::move(input));
  };
  return frames;
}

// Applies what the session delivers; the first failure is kept.
class StoringSink : public MapDeltaSink {
 public:
  StoringSink(storage::MapStore& store, storage::MapId map, storage::SessionId session)
      : store_(store), map_(map), session_(session) {}
  void OnDelta(MapDelta delta) override {
    if (status_.ok()) status_ = store_.Apply(map_, session_, delta);
  }
  const absl::Status& status() const { return status_; }

 private:
  storage::MapStore& store_;
  const storage::MapId map_;
  const storage::SessionId session_;
  absl::Status status_;
};

void KeepPicture(const MapScaleOptions& options, const FrameInput& frame) {
  const std::string name = absl::StrCat(options.QueryFolder(), "/", frame.sequence);
  cv::imwrite(name + ".png", frame.image);
  if (!frame.right.empty()) cv::imwrite(name + "r.png", frame.right);
}

absl::Status Drive(const MapScaleOptions& options, Frames frames, const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(const auto vocabulary, LoadVocabulary(options.slam.place));
  SEMMAP_ASSIGN_OR_RETURN(const auto store, storage::OpenMapStore(StoreAt(path)));
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, store->CreateMap({"drive", 1, frames.rig, true}));
  SEMMAP_ASSIGN_OR_RETURN(const storage::SessionInfo stored,
                          store->StartSession({map.id, "drive", "bench", 1, frames.rig}));
  StoringSink sink(*store, map.id, stored.id);
  const std::unique_ptr<Executor> executor = MakeThreadPool(1);
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session,
                          Session::Create(options.slam, frames.rig, &sink, executor.get(), vocabulary));
  for (int i = 0; i < options.frames; ++i) {
    SEMMAP_ASSIGN_OR_RETURN(const std::optional<FrameInput> frame, frames.next());
    if (!frame) break;
    session->WaitForMapper(0);
    SEMMAP_RETURN_IF_ERROR(session->Track(*frame).status());
    if (frame->sequence % kFramesPerQuery == 0) KeepPicture(options, *frame);
  }
  session->Finish();
  return sink.status();
}

}  // namespace

absl::Status MakeDrive(const MapScaleOptions& options) {
  if (std::filesystem::exists(options.DrivePath())) return absl::OkStatus();
  std::cerr << "driving " << options.source << "\n";
  std::filesystem::create_directories(options.QueryFolder());
  absl::string_view town = options.source;
  SEMMAP_ASSIGN_OR_RETURN(Frames frames, absl::ConsumePrefix(&town, "town:")
                                             ? OpenTown(std::string(town), options)
                                             : OpenRecording(options));
  // Under its name when it is whole.
  const std::string partial = options.DrivePath() + ".partial";
  std::filesystem::remove(partial);
  SEMMAP_RETURN_IF_ERROR(Drive(options, std::move(frames), partial));
  std::filesystem::rename(partial, options.DrivePath());
  return absl::OkStatus();
}

}  // namespace semmap::bench
