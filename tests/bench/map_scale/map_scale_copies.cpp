#include "tests/bench/map_scale/map_scale_copies.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/pipeline/place_describer.h"
#include "slam/place/vocabulary.h"
#include "storage/map_opener.h"
#include "storage/map_store.h"

namespace semmap::bench {
namespace {

constexpr int kCopiesPerRow = 8;
constexpr double kSpacing = 1500;  // metres
constexpr int kMaskBits = 112;
constexpr size_t kKeyFramesPerDelta = 40;
constexpr size_t kPointsPerDelta = 5000;

// The drive as it is stored.
class Original : public storage::MapReader {
 public:
  absl::Status OnMap(const storage::MapInfo& map) override {
    info = map;
    return absl::OkStatus();
  }
  absl::Status OnSession(const storage::SessionInfo&) override { return absl::OkStatus(); }
  absl::Status OnPoint(const MapPointRecord& point) override {
    points.push_back(point);
    return absl::OkStatus();
  }
  absl::Status OnKeyFrame(const storage::KeyFrameEntry& keyframe, KeyFrameObservations seen) override {
    keyframes.push_back(keyframe.record);
    observations.push_back(std::move(seen));
    return absl::OkStatus();
  }

  storage::MapInfo info;
  std::vector<MapPointRecord> points;
  std::vector<KeyFrameRecord> keyframes;
  std::vector<KeyFrameObservations> observations;
  std::vector<FramePose> frames;
};

absl::StatusOr<Original> ReadOriginal(const MapScaleOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(const auto store, storage::OpenMapStore(StoreAt(options.DrivePath())));
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, store->GetMap("drive"));
  Original original;
  SEMMAP_RETURN_IF_ERROR(store->ReadWhole(map.id, &original));
  SEMMAP_RETURN_IF_ERROR(store->ForEachTrajectoryPose(map.id, {}, [&](const storage::TrajectoryPose& pose) {
    const auto keyframe =
        std::lower_bound(original.keyframes.begin(), original.keyframes.end(), pose.reference_keyframe,
                         [](const KeyFrameRecord& record, KeyFrameId id) { return record.id < id; });
    original.frames.push_back({pose.sequence, pose.timestamp, pose.reference_keyframe,
                               keyframe->map_from_camera.Inverse() * pose.map_from_camera});
    return true;
  }));
  if (original.keyframes.empty()) return absl::FailedPreconditionError("the drive made no map");
  return original;
}

// Writes one copy.
class Copy {
 public:
  Copy(const Original& original, int index)
      : original_(original),
        shift_(ShiftOfCopy(index)),
        mask_(MaskOfCopy(index)),
        first_keyframe_(static_cast<uint64_t>(index) * original.info.last_keyframe_id.value()),
        first_point_(static_cast<uint64_t>(index) * original.info.last_point_id.value()) {}

  absl::Status Write(storage::MapStore& store, storage::MapId map, const std::string& name) {
    SEMMAP_ASSIGN_OR_RETURN(const storage::SessionInfo session,
                            store.StartSession({map, name, "bench", 1, original_.info.rig}));
    const auto apply = [&](MapDelta delta) {
      delta.version = ++version_;
      return store.Apply(map, session.id, delta);
    };
    for (size_t i = 0; i < original_.keyframes.size(); i += kKeyFramesPerDelta)
      SEMMAP_RETURN_IF_ERROR(apply(KeyFrames(i)));
    for (size_t i = 0; i < original_.points.size(); i += kPointsPerDelta)
      SEMMAP_RETURN_IF_ERROR(apply(Points(i)));
    MapDelta frames;
    for (FramePose frame : original_.frames) {
      frame.reference_keyframe = Moved(frame.reference_keyframe);
      frames.frames.push_back(frame);
    }
    return apply(std::move(frames));
  }

 private:
  KeyFrameId Moved(KeyFrameId id) const {
    return id.IsValid() ? KeyFrameId(id.value() + first_keyframe_) : id;
  }
  MapPointId Moved(MapPointId id) const { return id.IsValid() ? MapPointId(id.value() + first_point_) : id; }

  std::shared_ptr<const FrameFeatures> Moved(const FrameFeatures& features) const {
    auto moved = std::make_shared<FrameFeatures>(features);
    moved->frame_index.clear();
    for (Descriptor& descriptor : moved->descriptors) descriptor = Masked(descriptor, mask_);
    return moved;
  }

  MapDelta KeyFrames(size_t begin) const {
    MapDelta delta;
    for (size_t i = begin; i < std::min(begin + kKeyFramesPerDelta, original_.keyframes.size()); ++i) {
      KeyFrameRecord keyframe = original_.keyframes[i];
      keyframe.id = Moved(keyframe.id);
      keyframe.parent = Moved(keyframe.parent);
      keyframe.map_from_camera =
          SE3(keyframe.map_from_camera.rotation(), keyframe.map_from_camera.translation() + shift_);
      keyframe.features = Moved(*keyframe.features);
      KeyFrameObservations seen = original_.observations[i];
      seen.id = keyframe.id;
      for (MapPointId& point : seen.point_of_keypoint) point = Moved(point);
      seen.features = keyframe.features;
      delta.added_keyframes.push_back(std::move(keyframe));
      delta.observations.push_back(std::move(seen));
    }
    return delta;
  }

  MapDelta Points(size_t begin) const {
    MapDelta delta;
    for (size_t i = begin; i < std::min(begin + kPointsPerDelta, original_.points.size()); ++i) {
      MapPointRecord point = original_.points[i];
      point.id = Moved(point.id);
      point.reference_keyframe = Moved(point.reference_keyframe);
      point.position_in_map += shift_;
      point.descriptor = Masked(point.descriptor, mask_);
      delta.upserted_points.push_back(std::move(point));
    }
    return delta;
  }

  const Original& original_;
  const Eigen::Vector3d shift_;
  const Descriptor mask_;
  const uint64_t first_keyframe_;
  const uint64_t first_point_;
  uint64_t version_ = 0;
};

absl::Status WriteCopies(const MapScaleOptions& options, const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(const Original original, ReadOriginal(options));
  SEMMAP_ASSIGN_OR_RETURN(const auto vocabulary, LoadVocabulary(options.slam.place));
  SEMMAP_ASSIGN_OR_RETURN(const auto store, storage::OpenMapStore(StoreAt(path)));
  // As the server does.
  store->StoreWordsBy(
      storage::WordingOf(PlaceDescriber(vocabulary, options.slam.semantics.InactiveClasses())));
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map,
                          store->CreateMap({"large", 1, original.info.rig, true}));
  const uint64_t copies =
      std::max((options.keyframes + original.keyframes.size() - 1) / original.keyframes.size(),
               (options.points + original.points.size() - 1) / original.points.size());
  for (uint64_t index = 0; index < copies; ++index) {
    std::cerr << "copy " << index + 1 << " of " << copies << "\n";
    Copy copy(original, static_cast<int>(index));
    SEMMAP_RETURN_IF_ERROR(copy.Write(*store, map.id, absl::StrCat("copy-", index)));
  }
  return absl::OkStatus();
}

}  // namespace

Eigen::Vector3d ShiftOfCopy(int index) {
  return kSpacing * Eigen::Vector3d(index % kCopiesPerRow, 0, index / kCopiesPerRow);
}

Descriptor MaskOfCopy(int index) {
  Descriptor mask{};
  if (index == 0) return mask;
  std::mt19937 random(static_cast<uint32_t>(index));
  for (int set = 0; set < kMaskBits;) {
    const uint32_t bit = random() % 256;
    const uint64_t value = uint64_t{1} << (bit % 64);
    if ((mask.words[bit / 64] & value) != 0) continue;
    mask.words[bit / 64] |= value;
    ++set;
  }
  return mask;
}

Descriptor Masked(const Descriptor& descriptor, const Descriptor& mask) {
  Descriptor masked = descriptor;
  for (size_t i = 0; i < masked.words.size(); ++i) masked.words[i] ^= mask.words[i];
  return masked;
}

absl::Status MakeLargeMap(const MapScaleOptions& options) {
  if (std::filesystem::exists(options.MapPath())) return absl::OkStatus();
  const std::string partial = options.MapPath() + ".partial";
  for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(partial + suffix);
  SEMMAP_RETURN_IF_ERROR(WriteCopies(options, partial));
  std::filesystem::rename(partial, options.MapPath());
  return absl::OkStatus();
}

}  // namespace semmap::bench
