#include "slam/pipeline/map_snapshot.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace semmap {

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
  return std::make_shared<const MapSnapshot>(
      MapSnapshot{std::move(map), std::move(places), version, scale_known, bytes});
}

}  // namespace semmap
