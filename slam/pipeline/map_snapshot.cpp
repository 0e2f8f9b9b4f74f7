#include "slam/pipeline/map_snapshot.h"

#include <algorithm>
#include <utility>

namespace semmap {
namespace {

struct OwnedMap {
  Map map;
  PlaceMemory places;
};

class WholeMap : public MapInMemory {
 public:
  WholeMap(std::unique_ptr<const OwnedMap> owned, size_t memory_bytes, uint64_t version, bool scale_known)
      : MapInMemory(owned->map, owned->places, version, scale_known),
        owned_(std::move(owned)),
        memory_bytes_(memory_bytes) {}
  size_t memory_bytes() const override { return memory_bytes_; }

 private:
  const std::unique_ptr<const OwnedMap> owned_;
  const size_t memory_bytes_;
};

}  // namespace

std::optional<SE3> MapInMemory::FindPose(KeyFrameId id) const {
  const KeyFrame* keyframe = map_.FindKeyFrame(id);
  return keyframe == nullptr ? std::nullopt : std::optional<SE3>(keyframe->camera_from_map);
}

void MapInMemory::ForEachPose(absl::FunctionRef<void(const SE3& camera_from_map)> visit) const {
  for (const auto& [id, keyframe] : map_.keyframes()) visit(keyframe.camera_from_map);
}

void MapInMemory::ForEachObserver(MapPointId id, absl::FunctionRef<void(KeyFrameId)> visit) const {
  const MapPoint* point = map_.FindPoint(id);
  if (point == nullptr) return;
  for (const Observation& seen : point->observations) visit(seen.keyframe);
}

absl::StatusOr<std::optional<PlaceCandidate>> MapInMemory::Candidate(KeyFrameId id) const {
  const DirectIndex* nodes = memory_.NodesOf(id);
  if (nodes == nullptr || map_.FindKeyFrame(id) == nullptr) return std::optional<PlaceCandidate>();
  LocalMapViewLimits alone;
  alone.neighbours = 0;
  alone.keyframes = 1;
  // Nobody owns the nodes through this pointer: the map's owner does.
  return PlaceCandidate{MakeLocalMapView(map_, id, version_, alone),
                        std::shared_ptr<const DirectIndex>(std::shared_ptr<void>(), nodes)};
}

absl::StatusOr<std::shared_ptr<const LocalMapView>> MapInMemory::ViewAround(
    KeyFrameId id, const LocalMapViewLimits& limits) const {
  return MakeLocalMapView(map_, id, version_, limits);
}

std::shared_ptr<const MapSnapshot> MakeMapSnapshot(Map map, size_t map_bytes, uint64_t version,
                                                   bool scale_known,
                                                   std::shared_ptr<const Vocabulary> vocabulary,
                                                   const PlaceQueryLimits& limits, const ClassSet& inactive) {
  PlaceMemory places(std::move(vocabulary), limits, inactive);
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : map.keyframes()) ids.push_back(id);
  // In one order always: equal scores are told apart by it.
  std::sort(ids.begin(), ids.end());
  size_t bytes = map_bytes;
  for (const KeyFrameId id : ids) {
    const KeyFrame& keyframe = *map.FindKeyFrame(id);
    places.Add(keyframe);
    if (places.enabled()) bytes += places.NodesOf(id)->groups.size() * sizeof(NodeGroup);
    bytes += keyframe.features->size() * sizeof(uint32_t);
  }
  if (places.enabled()) bytes += places.index().MemoryBytes();
  auto owned = std::make_unique<const OwnedMap>(OwnedMap{std::move(map), std::move(places)});
  return std::make_shared<const WholeMap>(std::move(owned), bytes, version, scale_known);
}

}  // namespace semmap
