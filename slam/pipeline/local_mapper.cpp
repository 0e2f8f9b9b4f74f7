#include "slam/pipeline/local_mapper.h"

#include <algorithm>
#include <limits>
#include <unordered_set>

#include "slam/pipeline/local_bundle.h"
#include "slam/pipeline/point_fusion.h"

namespace semmap {
namespace {

// Fusion reaches the neighbours' neighbours: what the keyframe sees may long have been mapped from there.
constexpr int kFusionNeighbours = 10;
constexpr size_t kFusionSecondNeighbours = 3;

KeyFrame ToKeyFrame(const KeyFrameCandidate& candidate, const SE3& camera_from_map) {
  KeyFrame keyframe;
  keyframe.id = candidate.id;
  keyframe.sequence = candidate.sequence;
  keyframe.timestamp = candidate.timestamp;
  keyframe.camera_from_map = camera_from_map;
  keyframe.features = candidate.features;
  keyframe.grid = candidate.grid;
  keyframe.points.assign(candidate.features->size(), MapPointId());
  return keyframe;
}

}  // namespace

LocalMapper::LocalMapper(const SlamConfig& config, MappingCamera camera, ScalePyramidInfo scale_info,
                         Publish publish)
    : config_(config),
      camera_(std::move(camera)),
      map_(std::move(scale_info), config.semantics.PointPolicy()),
      filters_(!config.semantics.InactiveClasses().empty()),
      publish_(std::move(publish)) {}

std::vector<KeyFrameId> LocalMapper::AddKeyFrame(const KeyFrameCandidate& candidate,
                                                 const std::atomic<bool>* stop, YoungPoints* young) {
  Insert(candidate);
  young->OnKeyFrame();
  if (camera_.HasDepth()) {
    // The first keyframe has nothing but its depth: all of it is used.
    const double close_depth =
        map_.keyframes().size() == 1 ? std::numeric_limits<double>::max() : camera_.near_depth;
    young->Add(CreatePointsFromDepth(camera_, close_depth, candidate.id, &map_));
  }
  young->Cull(camera_.HasDepth(), &map_);
  CreatePoints(candidate.id, young);
  // The tracker gets the new points now; adjustment takes its time.
  PublishView(candidate.id);
  Fuse(candidate.id);
  if (map_.keyframes().size() > 2) AdjustLocalMap(config_.mapping, camera_.model, candidate.id, stop, &map_);
  auto culled = CullKeyFrames(config_.mapping, camera_.near_depth, candidate.id, &map_);
  PublishView(candidate.id);
  return culled;
}

void LocalMapper::Insert(const KeyFrameCandidate& candidate) {
  for (const PointSightings& sighting : candidate.sightings) {
    map_.AddSightings(sighting.point, sighting.visible, sighting.found);
  }
  SE3 camera_from_map = candidate.camera_from_reference;
  KeyFrameId reference = candidate.reference;
  while (reference.IsValid()) {
    if (const KeyFrame* keyframe = map_.FindKeyFrame(reference); keyframe != nullptr) {
      camera_from_map = camera_from_map * keyframe->camera_from_map;
      break;
    }
    // The reference was culled meanwhile; its heir knows where it was.
    const auto heir = map_.FindHeir(reference);
    if (!heir) break;
    camera_from_map = camera_from_map * heir->heir_from_removed.Inverse();
    reference = heir->heir;
  }
  map_.AddKeyFrame(ToKeyFrame(candidate, camera_from_map));
  for (size_t i = 0; i < candidate.points.size(); ++i) {
    const MapPointId point = candidate.points[i];
    if (point.IsValid() && map_.AddObservation(point, candidate.id, static_cast<uint32_t>(i)))
      map_.UpdateAppearance(point);
  }
  map_.ChooseParent(candidate.id);
}

void LocalMapper::AddInitialPair(const InitialPair& pair) {
  map_.AddKeyFrame(ToKeyFrame(pair.first, pair.first.camera_from_reference));
  map_.AddKeyFrame(ToKeyFrame(pair.second, pair.second.camera_from_reference));
  for (const InitialPair::Point& point : pair.points) {
    const MapPointId id = map_.AddPoint(point.position_in_map, pair.second.id);
    map_.AddObservation(id, pair.first.id, point.keypoint_in_first);
    map_.AddObservation(id, pair.second.id, point.keypoint_in_second);
    map_.UpdateAppearance(id);
  }
  map_.ChooseParent(pair.second.id);
  AdjustWholeMap(config_.mapping, camera_.model, &map_);
  PublishView(pair.second.id);
}

void LocalMapper::Reset() {
  map_.Clear();
  publish_(nullptr);
}

std::vector<KeyFrameId> LocalMapper::Neighbours(KeyFrameId id, int limit) const {
  std::vector<KeyFrameId> ids;
  for (const CovisibleKeyFrame& neighbour : map_.BestCovisible(id, static_cast<size_t>(limit))) {
    ids.push_back(neighbour.id);
  }
  return ids;
}

void LocalMapper::CreatePoints(KeyFrameId id, YoungPoints* young) {
  const int limit = camera_.HasDepth() ? config_.mapping.neighbours_to_triangulate_depth
                                       : config_.mapping.neighbours_to_triangulate;
  young->Add(TriangulatePoints(camera_, id, Neighbours(id, limit), &map_));
}

void LocalMapper::Fuse(KeyFrameId id) {
  std::vector<KeyFrameId> targets = Neighbours(id, kFusionNeighbours);
  std::unordered_set<KeyFrameId, IdHash> seen(targets.begin(), targets.end());
  seen.insert(id);
  for (size_t i = 0, direct = targets.size(); i < direct; ++i) {
    for (const CovisibleKeyFrame& second : map_.BestCovisible(targets[i], kFusionSecondNeighbours)) {
      if (seen.insert(second.id).second) targets.push_back(second.id);
    }
  }
  FuseWithNeighbours(camera_, id, targets, &map_);
  if (filters_) ObserveInactivePoints(camera_, id, Neighbours(id, kFusionNeighbours), &map_);
}

void LocalMapper::PublishView(KeyFrameId center) {
  while (map_.FindKeyFrame(center) == nullptr) {
    const auto heir = map_.FindHeir(center);
    center = heir ? heir->heir : map_.newest_keyframe();
  }
  publish_(MakeLocalMapView(map_, center, ++version_, LocalMapViewLimits()));
}

}  // namespace semmap
