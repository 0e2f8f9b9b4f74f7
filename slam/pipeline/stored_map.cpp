#include "slam/pipeline/stored_map.h"

#include <algorithm>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap {
namespace {

absl::Status NotInMemory() { return absl::NotFoundError("not in memory"); }

ViewPoint ToViewPoint(const MapPointRecord& record, uint8_t semantic_class) {
  return {
      record.id,         record.position_in_map,   record.normal, record.min_distance, record.max_distance,
      record.descriptor, record.observation_count, semantic_class};
}

absl::StatusOr<KeyFramePart> ToPart(StoredKeyFrame stored, const ScalePyramidInfo& scale_info) {
  const std::vector<Keypoint>& keypoints = stored.record.features->keypoints;
  const auto is_beyond = [&](const Keypoint& keypoint) { return keypoint.octave >= scale_info.levels(); };
  if (stored.observations.size() != keypoints.size() ||
      std::any_of(keypoints.begin(), keypoints.end(), is_beyond)) {
    return absl::DataLossError(absl::StrCat("keyframe ", stored.record.id.value(),
                                            " has observations or pyramid levels that it cannot have"));
  }
  auto grid = std::make_shared<const FeatureGrid>(stored.bounds, keypoints);
  return KeyFramePart{stored.record.map_from_camera.Inverse(), std::move(stored.record.features),
                      std::move(grid), std::move(stored.observations)};
}

}  // namespace

// Parts of one version: out of the cache, or read by `reader` and put there. Without a reader, what is not in
// the cache is an error.
class StoredMap::Parts {
 public:
  Parts(const StoredMap& map, uint64_t version, MapPartReader* reader)
      : map_(map), version_(version), reader_(reader) {}

  uint64_t version() const { return version_; }

  // nullptr when the map has no such keyframe.
  absl::StatusOr<std::shared_ptr<const KeyFramePart>> KeyFrame(KeyFrameId id) {
    if (auto part = map_.cache_->FindKeyFrame(map_.number_, id, version_)) return part;
    if (reader_ == nullptr) return NotInMemory();
    SEMMAP_ASSIGN_OR_RETURN(std::optional<StoredKeyFrame> stored, reader_->ReadKeyFrame(id));
    if (!stored) return std::shared_ptr<const KeyFramePart>();
    SEMMAP_ASSIGN_OR_RETURN(KeyFramePart read, ToPart(*std::move(stored), map_.reading_.scale_info));
    auto part = std::make_shared<const KeyFramePart>(std::move(read));
    map_.cache_->Put(map_.number_, id, version_, part);
    return part;
  }

  std::shared_ptr<const DirectIndex> Nodes(KeyFrameId id, const KeyFramePart& keyframe) {
    if (auto nodes = map_.cache_->FindNodes(map_.number_, id, version_)) return nodes;
    auto nodes = std::make_shared<const DirectIndex>(map_.Describe(*keyframe.features).nodes);
    map_.cache_->Put(map_.number_, id, version_, nodes);
    return nodes;
  }

  // nullptr when it is not there or inactive. Valid as long as this object.
  absl::StatusOr<const ViewPoint*> ActivePoint(MapPointId id) {
    std::shared_ptr<const PointBlock>& block = blocks_[PointBlock::NumberOf(id)];
    if (block == nullptr) {
      SEMMAP_ASSIGN_OR_RETURN(block, Block(PointBlock::NumberOf(id)));
    }
    return block->FindActive(id);
  }

 private:
  absl::StatusOr<std::shared_ptr<const PointBlock>> Block(uint64_t number) {
    if (auto block = map_.cache_->FindPoints(map_.number_, number, version_)) return block;
    if (reader_ == nullptr) return NotInMemory();
    auto block = std::make_shared<PointBlock>();
    const PointClassPolicy& classes = map_.reading_.classes;
    const MapPointId first(number * PointBlock::kSize);
    const MapPointId last(first.value() + PointBlock::kSize - 1);
    SEMMAP_RETURN_IF_ERROR(reader_->ReadPoints(first, last, [&](const MapPointRecord& record) {
      const uint8_t semantic_class = classes.ClassOf(ClassVotes(record.votes));
      block->Add(ToViewPoint(record, semantic_class), classes.IsActive(semantic_class));
    }));
    map_.cache_->Put(map_.number_, number, version_, block);
    return block;
  }

  const StoredMap& map_;
  const uint64_t version_;
  MapPartReader* const reader_;
  std::unordered_map<uint64_t, std::shared_ptr<const PointBlock>> blocks_;
};

// What views are copied from. The centre sees what its keyframe says, others what the outline does: of them
// the features need not be read.
class StoredMap::PartsAsSource : public LocalMapSource {
 public:
  PartsAsSource(const MapOutline& outline, KeyFrameId center, std::shared_ptr<const KeyFramePart> center_part,
                Parts* parts)
      : outline_(outline),
        center_(center),
        center_part_(std::move(center_part)),
        parts_(*parts),
        shared_(outline.keyframe_count(), 0) {}

  absl::StatusOr<std::vector<CovisibleKeyFrame>> BestCovisible(KeyFrameId id, size_t limit) override {
    std::vector<CovisibleKeyFrame> neighbours;
    const std::optional<uint32_t> slot = outline_.SlotOf(id);
    if (!slot) return neighbours;
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<uint32_t> others, CountShared(*slot));
    for (const uint32_t other : others)
      neighbours.push_back({outline_.places()[other].id, std::exchange(shared_[other], 0)});
    std::sort(neighbours.begin(), neighbours.end(),
              [](const CovisibleKeyFrame& a, const CovisibleKeyFrame& b) {
                return a.shared_points != b.shared_points ? a.shared_points > b.shared_points : a.id > b.id;
              });
    if (neighbours.size() > limit) neighbours.resize(limit);
    return neighbours;
  }

  absl::Status AddPointsOf(KeyFrameId id, size_t max_points, LocalMapView* view) override {
    if (id == center_) {
      for (const MapPointId point : center_part_->points) {
        if (point.IsValid()) SEMMAP_RETURN_IF_ERROR(AddPoint(point, max_points, view));
      }
    } else if (const std::optional<uint32_t> slot = outline_.SlotOf(id)) {
      for (const uint32_t index : outline_.PointsOf(*slot))
        SEMMAP_RETURN_IF_ERROR(AddPoint(outline_.PointId(index), max_points, view));
    }
    return absl::OkStatus();
  }

  absl::Status AddKeyFrame(KeyFrameId id, LocalMapView* view) override {
    SEMMAP_ASSIGN_OR_RETURN(const auto part, parts_.KeyFrame(id));
    if (part != nullptr) view->Add({id, part->camera_from_map, part->features, part->grid, {}}, part->points);
    return absl::OkStatus();
  }

 private:
  // Fills shared_ for the keyframes it answers; who takes it up sets it back.
  absl::StatusOr<std::vector<uint32_t>> CountShared(uint32_t slot) {
    std::vector<uint32_t> others;
    for (const uint32_t index : outline_.PointsOf(slot)) {
      const auto point = parts_.ActivePoint(outline_.PointId(index));
      if (!point.ok()) {
        for (const uint32_t other : others) shared_[other] = 0;
        return point.status();
      }
      if (*point == nullptr) continue;
      for (const uint32_t observer : outline_.ObserversOf(index)) {
        if (observer != slot && shared_[observer]++ == 0) others.push_back(observer);
      }
    }
    return others;
  }

  absl::Status AddPoint(MapPointId id, size_t max_points, LocalMapView* view) {
    if (view->size() >= max_points || view->IndexOf(id) >= 0) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(const ViewPoint* point, parts_.ActivePoint(id));
    if (point != nullptr) view->Add(*point);
    return absl::OkStatus();
  }

  const MapOutline& outline_;
  const KeyFrameId center_;
  const std::shared_ptr<const KeyFramePart> center_part_;
  Parts& parts_;
  std::vector<int> shared_;  // by slot, all zero between counts
};

StoredMap::StoredMap(Reading reading, Core core, std::shared_ptr<MapPartSource> source,
                     std::shared_ptr<MapPartCache> cache, uint64_t number)
    : reading_(std::move(reading)),
      core_(std::move(core)),
      source_(std::move(source)),
      cache_(std::move(cache)),
      number_(number),
      memory_bytes_(sizeof(StoredMap) + core_.outline.MemoryBytes() +
                    (core_.places ? core_.places->MemoryBytes() : 0)),
      newest_version_(core_.version) {}

std::optional<SE3> StoredMap::FindPose(KeyFrameId id) const {
  const std::optional<uint32_t> slot = core_.outline.SlotOf(id);
  return slot ? std::optional<SE3>(core_.outline.places()[*slot].camera_from_map) : std::nullopt;
}

void StoredMap::ForEachPose(absl::FunctionRef<void(const SE3& camera_from_map)> visit) const {
  for (const MapOutline::Place& place : core_.outline.places()) visit(place.camera_from_map);
}

void StoredMap::ForEachObserver(MapPointId id, absl::FunctionRef<void(KeyFrameId)> visit) const {
  const std::optional<uint32_t> index = core_.outline.IndexOf(id);
  if (!index) return;
  for (const uint32_t slot : core_.outline.ObserversOf(*index)) visit(core_.outline.places()[slot].id);
}

template <typename Work>
absl::Status StoredMap::WithParts(const Work& work) const {
  Parts in_memory(*this, newest_version_, nullptr);
  if (work(&in_memory).ok()) return absl::OkStatus();
  return source_->Read([&](MapPartReader& reader) {
    newest_version_ = reader.version();
    Parts parts(*this, reader.version(), &reader);
    return work(&parts);
  });
}

absl::StatusOr<std::shared_ptr<const LocalMapView>> StoredMap::MakeView(KeyFrameId id,
                                                                        const LocalMapViewLimits& limits,
                                                                        Parts* parts) const {
  SEMMAP_ASSIGN_OR_RETURN(auto center, parts->KeyFrame(id));
  if (center == nullptr) return std::shared_ptr<const LocalMapView>();
  auto view = std::make_shared<LocalMapView>();
  view->version = parts->version();
  view->map_keyframes = static_cast<int>(keyframe_count());
  PartsAsSource source(core_.outline, id, std::move(center), parts);
  SEMMAP_RETURN_IF_ERROR(FillLocalMapView(id, limits, &source, view.get()));
  return view;
}

absl::StatusOr<std::optional<PlaceCandidate>> StoredMap::Candidate(KeyFrameId id) const {
  LocalMapViewLimits alone;
  alone.neighbours = 0;
  alone.keyframes = 1;
  std::optional<PlaceCandidate> candidate;
  SEMMAP_RETURN_IF_ERROR(WithParts([&](Parts* parts) -> absl::Status {
    candidate.reset();
    SEMMAP_ASSIGN_OR_RETURN(const auto keyframe, parts->KeyFrame(id));
    SEMMAP_ASSIGN_OR_RETURN(auto view, MakeView(id, alone, parts));
    if (view != nullptr) candidate = PlaceCandidate{std::move(view), parts->Nodes(id, *keyframe)};
    return absl::OkStatus();
  }));
  return candidate;
}

absl::StatusOr<std::shared_ptr<const LocalMapView>> StoredMap::ViewAround(
    KeyFrameId id, const LocalMapViewLimits& limits) const {
  std::shared_ptr<const LocalMapView> view;
  SEMMAP_RETURN_IF_ERROR(WithParts([&](Parts* parts) -> absl::Status {
    SEMMAP_ASSIGN_OR_RETURN(view, MakeView(id, limits, parts));
    return absl::OkStatus();
  }));
  return view;
}

}  // namespace semmap
