#include "tests/bench/map_scale/map_scale_measure.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/recall.h"
#include "slam/pipeline/frame_builder.h"
#include "slam/pipeline/map_localizer.h"
#include "slam/pipeline/session.h"
#include "slam/place/vocabulary.h"
#include "storage/map_loader.h"
#include "storage/map_opener.h"
#include "storage/map_store.h"
#include "tests/bench/map_scale/map_scale_copies.h"
#include "tests/bench/slam_bench_meters.h"

namespace semmap::bench {
namespace {

constexpr double kRightMetres = 0.5;
constexpr double kRightRadians = 5 * std::numbers::pi / 180;
constexpr int kBoxes = 60;
constexpr size_t kBoxPoints = 10'000;
// Copies of a drive may lie far apart, metres.
constexpr double kLargestHalf = 1e6;

class Timer {
 public:
  double Ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double ResidentMb() {
  std::ifstream file("/proc/self/statm");
  double total = 0;
  double resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

// Writes back and drops what the system holds of the file.
void DropFromPageCache(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  fsync(file);
  posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  close(file);
}

// A frame of the drive that is asked for in a copy of it.
struct Question {
  uint64_t sequence = 0;
  SE3 map_from_camera;  // in the drive
  int copy = 0;
};

FrameInput ReadPicture(const MapScaleOptions& options, uint64_t sequence) {
  const std::string name = absl::StrCat(options.QueryFolder(), "/", sequence);
  FrameInput input;
  input.sequence = sequence;
  input.timestamp = static_cast<TimestampNs>(sequence) * 100'000'000;
  input.image = cv::imread(name + ".png", cv::IMREAD_GRAYSCALE);
  if (options.sensor == SensorType::kStereo) input.right = cv::imread(name + "r.png", cv::IMREAD_GRAYSCALE);
  return input;
}

class Measurement {
 public:
  explicit Measurement(const MapScaleOptions& options) : options_(options) {}

  absl::StatusOr<MapScaleResult> Run() {
    SEMMAP_ASSIGN_OR_RETURN(vocabulary_, LoadVocabulary(options_.slam.place));
    SEMMAP_RETURN_IF_ERROR(ReadQuestions());
    SEMMAP_RETURN_IF_ERROR(OpenTwice());
    SEMMAP_RETURN_IF_ERROR(AskAll());
    SEMMAP_RETURN_IF_ERROR(DriveInMap());
    result_.resident_mb = ResidentMb();
    result_.peak_mb = PeakRssMb();
    result_.core_mb = static_cast<double>(map_->memory_bytes()) / (1 << 20);
    result_.map_mb = result_.core_mb + static_cast<double>(parts_->memory_bytes()) / (1 << 20);
    SEMMAP_RETURN_IF_ERROR(AskForBoxes());
    SEMMAP_RETURN_IF_ERROR(Describe());
    return std::move(result_);
  }

 private:
  absl::Status ReadQuestions() {
    SEMMAP_ASSIGN_OR_RETURN(const auto store, storage::OpenMapStore(StoreAt(options_.DrivePath())));
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, store->GetMap("drive"));
    rig_ = map.rig;
    keyframes_of_copy_ = map.keyframe_count;
    SEMMAP_RETURN_IF_ERROR(store->ForEachTrajectoryPose(map.id, {}, [&](const storage::TrajectoryPose& pose) {
      const std::string picture = absl::StrCat(options_.QueryFolder(), "/", pose.sequence, ".png");
      if (std::filesystem::exists(picture)) drive_.push_back({pose.sequence, pose.map_from_camera, 0});
      return true;
    }));
    return drive_.empty() ? absl::FailedPreconditionError("the drive left no pictures") : absl::OkStatus();
  }

  absl::Status Open() {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo info, store_->GetMap("large"));
    const ScalePyramidInfo scale_info(options_.slam.orb.levels, options_.slam.orb.scale_factor);
    const SemanticsConfig& semantics = options_.slam.semantics;
    const size_t max_bytes = options_.memory_mb << 20;
    if (options_.whole) {
      SEMMAP_ASSIGN_OR_RETURN(
          storage::RestoredMap restored,
          storage::LoadMap(*store_, info.id, scale_info, SIZE_MAX, semantics.PointPolicy()));
      map_ = MakeMapSnapshot(std::move(restored.map), restored.memory_bytes, info.version, info.scale_known,
                             vocabulary_, options_.slam.place.query, semantics.InactiveClasses());
      return absl::OkStatus();
    }
    const storage::MapOpening opening{
        {scale_info, semantics.PointPolicy(), PlaceDescriber(vocabulary_, semantics.InactiveClasses())},
        options_.slam.place.query,
        parts_};
    SEMMAP_ASSIGN_OR_RETURN(map_, storage::OpenMap(*store_, info.id, opening, max_bytes));
    parts_->SetMaxBytes(max_bytes - map_->memory_bytes());
    return absl::OkStatus();
  }

  absl::Status OpenTwice() {
    builder_.emplace(options_.slam, rig_, nullptr);
    // The extractor's memory is no part of the map's.
    Extract(drive_.front());
    DropFromPageCache(options_.MapPath());
    result_.before_mb = ResidentMb();
    SEMMAP_RETURN_IF_ERROR(OpenAndAskOnce(&result_.from_disk));
    map_.reset();
    store_.reset();
    parts_ = std::make_shared<MapPartCache>(options_.memory_mb << 20);
    return OpenAndAskOnce(&result_.from_page_cache);
  }

  absl::Status OpenAndAskOnce(MapScaleResult::Opening* opening) {
    SEMMAP_ASSIGN_OR_RETURN(store_, storage::OpenMapStore(StoreAt(options_.MapPath())));
    const Timer timer;
    SEMMAP_RETURN_IF_ERROR(Open());
    opening->open_ms = timer.Ms();
    copies_ = static_cast<int>(map_->keyframe_count() / keyframes_of_copy_);
    Question first = drive_[drive_.size() / 2];
    first.copy = copies_ / 2;
    SEMMAP_RETURN_IF_ERROR(Ask(first).status());
    opening->first_answer_ms = timer.Ms();
    return absl::OkStatus();
  }

  TrackedFrame Extract(const Question& question) {
    const FrameInput input = ReadPicture(options_, question.sequence);
    StageTimes times;
    const Timer timer;
    TrackedFrame frame = builder_->Build(input, false, &times);
    last_extract_ms_ = timer.Ms();
    return frame;
  }

  absl::StatusOr<MapLocalization> Ask(const Question& question) {
    const TrackedFrame frame = Extract(question);
    FrameFeatures features = *frame.features;
    const Descriptor mask = MaskOfCopy(question.copy);
    for (Descriptor& descriptor : features.descriptors) descriptor = Masked(descriptor, mask);
    const MapLocalizer localizer(options_.slam.relocalization, static_cast<uint32_t>(options_.slam.seed));
    const Timer timer;
    auto located = localizer.Locate(*map_, MakeMappingCamera(options_.slam, *builder_),
                                    {features, *frame.grid}, PlacePrior());
    last_ask_ms_ = timer.Ms();
    return located;
  }

  // Anywhere in the map, in no order.
  absl::Status AskAll() {
    std::mt19937 random(7);
    for (int i = 0; i < options_.queries; ++i) {
      Question question = drive_[random() % drive_.size()];
      question.copy = static_cast<int>(random() % static_cast<uint32_t>(copies_));
      SEMMAP_ASSIGN_OR_RETURN(const MapLocalization located, Ask(question));
      result_.relocalize_ms.push_back(last_ask_ms_);
      result_.extract_ms.push_back(last_extract_ms_);
      if (!located.found) continue;
      ++result_.found;
      const SE3 truth(question.map_from_camera.rotation(),
                      question.map_from_camera.translation() + ShiftOfCopy(question.copy));
      const PoseError error = ComparePoses(truth, located.found->fix.camera_from_map.Inverse());
      if (error.translation_m < kRightMetres && error.rotation_rad < kRightRadians) ++result_.right;
    }
    return absl::OkStatus();
  }

  // The pictures of the drive, one after the other: a vehicle that is three times as fast.
  absl::Status DriveInMap() {
    struct NoSink : MapDeltaSink {
      void OnDelta(MapDelta /*delta*/) override {}
    } sink;
    SessionStart start;
    start.localize = map_;
    SEMMAP_ASSIGN_OR_RETURN(const auto session, Session::Create(options_.slam, rig_, &sink, nullptr,
                                                                vocabulary_, nullptr, std::move(start)));
    for (const Question& question : drive_) {
      const FrameInput input = ReadPicture(options_, question.sequence);
      const Timer timer;
      SEMMAP_ASSIGN_OR_RETURN(const FrameResult tracked, session->Track(input));
      result_.localize_ms.push_back(timer.Ms());
      if (tracked.state == TrackingState::kTracking) ++result_.localized;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<size_t> CountIn(storage::MapId map, const Eigen::AlignedBox3d& box) {
    storage::MapPointQuery query;
    query.box = box;
    size_t count = 0;
    SEMMAP_RETURN_IF_ERROR(store_->ForEachMapPoint(map, query, [&](const MapPointRecord&) {
      ++count;
      return true;
    }));
    return count;
  }

  // Boxes around places of the drive that hold about as many points as wanted.
  absl::Status AskForBoxes() {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, store_->GetMap("large"));
    std::mt19937 random(11);
    for (int i = 0; i < kBoxes; ++i) {
      const int copy = static_cast<int>(random() % static_cast<uint32_t>(copies_));
      const Eigen::Vector3d center =
          drive_[random() % drive_.size()].map_from_camera.translation() + ShiftOfCopy(copy);
      double half = 5;
      Eigen::AlignedBox3d box;
      for (size_t count = 0; count < kBoxPoints && half < kLargestHalf; half *= 1.15) {
        box = Eigen::AlignedBox3d(center.array() - half, center.array() + half);
        SEMMAP_ASSIGN_OR_RETURN(count, CountIn(map.id, box));
      }
      const Timer timer;
      SEMMAP_ASSIGN_OR_RETURN(const size_t count, CountIn(map.id, box));
      result_.box_ms.push_back(timer.Ms());
      result_.box_points.push_back(static_cast<double>(count));
    }
    return absl::OkStatus();
  }

  absl::Status Describe() {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, store_->GetMap("large"));
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapSummary summary, store_->Summarize(map.id));
    result_.keyframes = map.keyframe_count;
    result_.points = map.point_count;
    result_.kilometres = summary.trajectory_length / 1000;
    result_.file_bytes = summary.database_bytes;
    return absl::OkStatus();
  }

  const MapScaleOptions& options_;
  MapScaleResult result_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  CameraRig rig_;
  uint64_t keyframes_of_copy_ = 1;
  std::vector<Question> drive_;
  std::optional<FrameBuilder> builder_;
  std::unique_ptr<storage::MapStore> store_;
  std::shared_ptr<MapPartCache> parts_ = std::make_shared<MapPartCache>(options_.memory_mb << 20);
  std::shared_ptr<const MapSnapshot> map_;
  int copies_ = 1;
  double last_extract_ms_ = 0;
  double last_ask_ms_ = 0;
};

}  // namespace

absl::StatusOr<MapScaleResult> Measure(const MapScaleOptions& options) { return Measurement(options).Run(); }

}  // namespace semmap::bench
