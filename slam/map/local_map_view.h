#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/common/ids.h"
#include "slam/map/map.h"

namespace semmap {

// A keyframe of the view, with its points as indices into the view.
struct ViewKeyFrame {
  KeyFrameId id;
  SE3 camera_from_map;
  std::shared_ptr<const FrameFeatures> features;
  std::shared_ptr<const FeatureGrid> grid;
  // For each keypoint an index into the view's points, or -1.
  std::vector<int32_t> point_of_keypoint;
};

// A point on its way into a view.
struct ViewPoint {
  MapPointId id;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float min_distance = 0;
  float max_distance = 0;
  Descriptor descriptor;
  uint32_t observation_count = 0;
  uint8_t semantic_class = kUnknownClass;
};

// The active part of the map around one keyframe (the newest, or where a lost camera was found), copied out
// for the tracker: immutable once published, so it is read without a lock while the mapper goes on. Points
// are kept as parallel arrays, because the tracker sweeps all of them for every frame.
struct LocalMapView {
  uint64_t version = 0;
  // Count of keyframes in the whole map when the view was made.
  int map_keyframes = 0;

  std::vector<MapPointId> ids;
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3f> normals;
  std::vector<float> min_distances;
  std::vector<float> max_distances;
  std::vector<Descriptor> descriptors;
  std::vector<uint32_t> observation_counts;
  std::vector<uint8_t> classes;  // ids of SemanticClass
  std::unordered_map<MapPointId, int32_t, IdHash> index_of_id;

  // The keyframe around which the view was made comes first and is the reference of tracking; then the
  // nearest by covisibility. Never empty.
  std::vector<ViewKeyFrame> keyframes;

  size_t size() const { return ids.size(); }
  const ViewKeyFrame& reference() const { return keyframes.front(); }
  // -1 when the point is not (or no longer) part of the view.
  int32_t IndexOf(MapPointId id) const {
    const auto found = index_of_id.find(id);
    return found == index_of_id.end() ? -1 : found->second;
  }
  const ViewKeyFrame* FindKeyFrame(KeyFrameId id) const;

  // --- for who makes a view; the point is not in it yet
  void Add(const ViewPoint& point);
  // `keyframe` without point_of_keypoint, which follows from `points`.
  void Add(ViewKeyFrame keyframe, std::span<const MapPointId> points);
};

struct LocalMapViewLimits {
  size_t neighbours = 30;        // covisible keyframes whose points take part
  size_t second_neighbours = 3;  // of each of the ten best of them
  size_t max_points = 20000;
  size_t keyframes = 7;  // that bring their features along, for matching by descriptor alone; at least 1
};

// What a view is copied from: a map in memory, or one that is read as it is needed. Statuses are those of
// reading.
class LocalMapSource {
 public:
  virtual ~LocalMapSource() = default;
  // As Map::BestCovisible.
  virtual absl::StatusOr<std::vector<CovisibleKeyFrame>> BestCovisible(KeyFrameId id, size_t limit) = 0;
  // Adds the active points that the keyframe sees and the view does not have, in the order of its keypoints,
  // until the view has `max_points`.
  virtual absl::Status AddPointsOf(KeyFrameId id, size_t max_points, LocalMapView* view) = 0;
  // Adds the keyframe itself.
  virtual absl::Status AddKeyFrame(KeyFrameId id, LocalMapView* view) = 0;
};

// Copies the surroundings of a keyframe, which must be there. Its own points come first, whatever the limits.
absl::Status FillLocalMapView(KeyFrameId center, const LocalMapViewLimits& limits, LocalMapSource* source,
                              LocalMapView* view);

// Copies the surroundings of keyframe `center`. nullptr when the map does not have it.
std::shared_ptr<const LocalMapView> MakeLocalMapView(const Map& map, KeyFrameId center, uint64_t version,
                                                     const LocalMapViewLimits& limits);

}  // namespace semmap
