#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "slam/map/local_map_view.h"
#include "slam/map/map.h"
#include "slam/pipeline/culling.h"
#include "slam/pipeline/keyframe_candidate.h"
#include "slam/pipeline/point_creation.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Takes the tracker's keyframes into the map and tends the surroundings of each: new points, fusion, culling,
// local bundle adjustment. Owns the map. Not thread-safe: its queue calls it from one thread at a time.
class LocalMapper {
 public:
  // Called whenever the tracker should see the map's new state.
  using Publish = std::function<void(std::shared_ptr<const LocalMapView>)>;

  LocalMapper(const SlamConfig& config, MappingCamera camera, ScalePyramidInfo scale_info, Publish publish);

  // `stop` becomes true when the next keyframe waits: what can be left out then is. `young` are the points of
  // the vehicle whose keyframe it is. Returns the keyframes that it made superfluous and removed.
  std::vector<KeyFrameId> AddKeyFrame(const KeyFrameCandidate& candidate, const std::atomic<bool>* stop,
                                      YoungPoints* young);
  void AddInitialPair(const InitialPair& pair);
  // Forgets the map.
  void Reset();

  // Publishes a view around this keyframe, or, when that was culled, around its heir.
  void PublishView(KeyFrameId center);

  const Map& map() const { return map_; }
  // Of the view published last.
  uint64_t view_version() const { return version_; }
  // For steps of the map's owner that are not local; PublishView makes them known.
  Map& mutable_map() { return map_; }
  // Changes since the last call.
  MapDelta TakeDelta() { return map_.TakeDelta(); }

 private:
  void Insert(const KeyFrameCandidate& candidate);
  void CreatePoints(KeyFrameId id, YoungPoints* young);
  // With the neighbours and their neighbours.
  void Fuse(KeyFrameId id);
  std::vector<KeyFrameId> Neighbours(KeyFrameId id, int limit) const;

  SlamConfig config_;
  MappingCamera camera_;
  Map map_;
  bool filters_;  // points may be inactive
  Publish publish_;
  uint64_t version_ = 0;
};

}  // namespace semmap
