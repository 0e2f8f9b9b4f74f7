#include "slam/pipeline/point_creation.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "slam/geometry/triangulation.h"
#include "slam/pipeline/association.h"

namespace semmap {
namespace {

constexpr size_t kMinDepthPoints = 100;
// Monocular neighbours must be apart by this share of the scene's depth.
constexpr double kMinBaselineShare = 0.01;
// Rays closer than this (0.8 degrees apart) give no depth worth having.
constexpr double kMaxParallaxCosine = 0.9999;
// 95 % quantile of chi^2 with one degree of freedom: distance to the epipolar line.
constexpr double kChi2Line = 3.841;
// Half the side of the windows in which the epipolar line is walked, pixels.
constexpr float kWalkRadius = 12;
constexpr int kMaxWalkSteps = 80;
// Nearest depth tried, as a share of the keyframe's median depth.
constexpr double kNearestDepthShare = 0.1;
// Depth from stereo or RGB-D is trusted within this factor.
constexpr double kDepthFactor = 2.0;

double MedianDepth(const KeyFrame& keyframe, const Map& map) {
  std::vector<double> depths;
  for (const MapPointId id : keyframe.points) {
    const MapPoint* point = id.IsValid() ? map.FindActivePoint(id) : nullptr;
    if (point != nullptr) depths.push_back((keyframe.camera_from_map * point->position_in_map).z());
  }
  if (depths.empty()) return 0;
  std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
  return depths[depths.size() / 2];
}

// Where the second image can see a keypoint of the first: a piece of its epipolar line.
struct EpipolarSegment {
  EpipolarSegment(const Eigen::Vector2d& near_end, const Eigen::Vector2d& far_end)
      : near(near_end), far(far_end), length((far_end - near_end).norm()) {
    const Eigen::Vector2d along = (far - near) / length;
    line = Eigen::Vector3d(-along.y(), along.x(), along.y() * near.x() - along.x() * near.y()).cast<float>();
  }

  // Signed distance of a pixel to the (infinite) line.
  float Distance(float x, float y) const { return line.x() * x + line.y() * y + line.z(); }

  Eigen::Vector2d near;
  Eigen::Vector2d far;
  double length;
  Eigen::Vector3f line;  // normal and offset
};

// Everything about one pair of keyframes that does not depend on the keypoint.
class PairGeometry {
 public:
  PairGeometry(const MappingCamera& camera, const KeyFrame& first, const KeyFrame& second,
               double median_depth)
      : camera_(camera),
        second_from_first_(second.camera_from_map * first.camera_from_map.Inverse()),
        rotation_(second_from_first_.RotationMatrix()),
        median_depth_(median_depth) {}

  std::optional<EpipolarSegment> Segment(const Keypoint& keypoint) const {
    const Eigen::Vector3d ray = RayOfPixel(camera_.rig.camera, {keypoint.x, keypoint.y});
    double nearest = kNearestDepthShare * median_depth_;
    double furthest = 1e3 * median_depth_;
    if (keypoint.HasDepth()) {
      nearest = keypoint.depth / kDepthFactor;
      furthest = keypoint.depth * kDepthFactor;
    }
    const Eigen::Vector3d direction = rotation_ * ray;
    // Only the part in front of the second camera counts.
    const double min_z = 0.1 * nearest;
    if (direction.z() <= 0) return std::nullopt;
    const double z_at_nearest = direction.z() * nearest + second_from_first_.translation().z();
    if (z_at_nearest < min_z) nearest = (min_z - second_from_first_.translation().z()) / direction.z();
    if (nearest >= furthest) return std::nullopt;
    const Eigen::Vector2d near = Project(direction * nearest);
    const Eigen::Vector2d far = Project(direction * furthest);
    if ((far - near).squaredNorm() < 1.0) return std::nullopt;
    return EpipolarSegment(near, far);
  }

 private:
  Eigen::Vector2d Project(const Eigen::Vector3d& rotated) const {
    return ProjectPinhole(camera_.rig.camera, rotated + second_from_first_.translation());
  }

  const MappingCamera& camera_;
  SE3 second_from_first_;
  Eigen::Matrix3d rotation_;
  double median_depth_;
};

// Clips the segment's walk to the image (parameters along the segment); false when it misses the image.
bool ClipToImage(const EpipolarSegment& segment, const ImageBounds& bounds, double* begin, double* end) {
  *begin = 0;
  *end = 1;
  const Eigen::Vector2d along = segment.far - segment.near;
  const double low[2] = {bounds.min_x, bounds.min_y};
  const double high[2] = {bounds.max_x, bounds.max_y};
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(along[axis]) < 1e-9) {
      if (segment.near[axis] < low[axis] || segment.near[axis] > high[axis]) return false;
      continue;
    }
    double enter = (low[axis] - segment.near[axis]) / along[axis];
    double leave = (high[axis] - segment.near[axis]) / along[axis];
    if (enter > leave) std::swap(enter, leave);
    *begin = std::max(*begin, enter);
    *end = std::min(*end, leave);
  }
  return *begin < *end;
}

// The second image as the walk along its lines sees it: only keypoints that see no point yet, in a grid of
// their own.
class FreeKeypoints {
 public:
  FreeKeypoints(const MappingCamera& camera, const KeyFrame& keyframe, const ScalePyramidInfo& scale_info)
      : rule_(camera.association), bounds_(camera.bounds), descriptors_(keyframe.features->descriptors) {
    for (size_t i = 0; i < keyframe.points.size(); ++i) {
      if (keyframe.points[i].IsValid()) continue;
      const Keypoint& keypoint = keyframe.features->keypoints[i];
      keypoints_.push_back(keypoint);
      indices_.push_back(static_cast<int>(i));
      reach_.push_back(static_cast<float>(std::sqrt(kChi2Line / scale_info.inverse_sigma2[keypoint.octave])));
    }
    grid_.Assign(bounds_, keypoints_);
  }

  // The keypoint closest to `descriptor` among those near the segment, within two octaves; second -1 if none.
  KeypointPair FindAlong(const EpipolarSegment& segment, const Descriptor& descriptor,
                         const Keypoint& seen) const {
    KeypointPair best{-1, -1, kStrictDistance + 1};
    double begin = 0;
    double end = 1;
    if (!ClipToImage(segment, bounds_, &begin, &end)) return best;
    const int steps =
        std::min(kMaxWalkSteps, 1 + static_cast<int>((end - begin) * segment.length / (2 * kWalkRadius)));
    for (int step = 0; step < steps; ++step) {
      const double t = begin + (end - begin) * (step + 0.5) / steps;
      const Eigen::Vector2f center = (segment.near + t * (segment.far - segment.near)).cast<float>();
      grid_.ForEachInWindow(keypoints_, center.x(), center.y(), kWalkRadius, [&](int index) {
        const Keypoint& keypoint = keypoints_[index];
        if (std::abs(segment.Distance(keypoint.x, keypoint.y)) > reach_[index]) return;
        if (std::abs(keypoint.octave - seen.octave) > 2) return;
        const int distance = rule_.Distance(descriptor, seen, descriptors_[indices_[index]], keypoint);
        if (distance < best.distance) best = {-1, indices_[index], distance};
      });
    }
    return best;
  }

 private:
  AssociationRule rule_;
  ImageBounds bounds_;
  const std::vector<Descriptor>& descriptors_;
  std::vector<Keypoint> keypoints_;
  std::vector<int> indices_;  // into the keyframe's keypoints
  std::vector<float> reach_;  // greatest distance to the line, pixels
  FeatureGrid grid_;
};

std::vector<KeypointPair> MatchAlongLines(const MappingCamera& camera, const PairGeometry& geometry,
                                          const KeyFrame& first, const KeyFrame& second, const Map& map) {
  std::vector<KeypointPair> pairs;
  const FreeKeypoints free(camera, second, map.scale_info());
  for (size_t i = 0; i < first.points.size(); ++i) {
    if (first.points[i].IsValid()) continue;
    const Keypoint& keypoint = first.features->keypoints[i];
    const auto segment = geometry.Segment(keypoint);
    if (!segment) continue;
    KeypointPair pair = free.FindAlong(*segment, first.features->descriptors[i], keypoint);
    if (pair.second < 0) continue;
    pair.first = static_cast<int>(i);
    pairs.push_back(pair);
  }
  KeepBestOfSecond(second.features->size(), &pairs);
  KeepConsistentRotation(first.features->keypoints, second.features->keypoints, &pairs);
  return pairs;
}

bool ReprojectsWell(const MappingCamera& camera, const KeyFrame& keyframe, const Keypoint& keypoint,
                    float inverse_sigma2, const Eigen::Vector3d& position_in_map) {
  const Eigen::Vector3d point = keyframe.camera_from_map * position_in_map;
  if (point.z() <= 0) return false;
  const Eigen::Vector2d pixel = ProjectPinhole(camera.rig.camera, point);
  double squared = (pixel - Eigen::Vector2d(keypoint.x, keypoint.y)).squaredNorm();
  if (keypoint.right_x < 0) return squared * inverse_sigma2 <= kChi2Mono;
  const double right = pixel.x() - camera.model.focal_times_baseline / point.z() - keypoint.right_x;
  squared += right * right;
  return squared * inverse_sigma2 <= kChi2Stereo;
}

// A point twice as far must appear on a pyramid level of half the scale, roughly.
bool ScalesAgree(const Map& map, const KeyFrame& first, const Keypoint& first_seen, const KeyFrame& second,
                 const Keypoint& second_seen, const Eigen::Vector3d& position_in_map) {
  const double first_distance = (position_in_map - first.Center()).norm();
  const double second_distance = (position_in_map - second.Center()).norm();
  if (first_distance <= 0 || second_distance <= 0) return false;
  const double distance_ratio = second_distance / first_distance;
  const double scale_ratio =
      map.scale_info().scales[first_seen.octave] / map.scale_info().scales[second_seen.octave];
  const double tolerance = 1.5 * map.scale_info().scale_factor;
  return distance_ratio <= scale_ratio * tolerance && distance_ratio * tolerance >= scale_ratio;
}

// The angle under which the two eyes of a depth camera see the keypoint's point, as a cosine.
double StereoParallaxCosine(const MappingCamera& camera, const Keypoint& keypoint) {
  if (!camera.HasDepth() || !keypoint.HasDepth()) return 1.0;
  return std::cos(2 * std::atan2(0.5 * camera.rig.baseline_m, static_cast<double>(keypoint.depth)));
}

Eigen::Vector3d Unproject(const MappingCamera& camera, const KeyFrame& keyframe, const Keypoint& keypoint) {
  return keyframe.camera_from_map.Inverse() *
         (keypoint.depth * RayOfPixel(camera.rig.camera, {keypoint.x, keypoint.y}));
}

// By two views or by either one's own depth, whichever sees the point under the widest angle.
std::optional<Eigen::Vector3d> LocatePoint(const MappingCamera& camera, const KeyFrame& first,
                                           const Keypoint& first_seen, const KeyFrame& second,
                                           const Keypoint& second_seen) {
  const Eigen::Vector3d first_ray = RayOfPixel(camera.rig.camera, {first_seen.x, first_seen.y});
  const Eigen::Vector3d second_ray = RayOfPixel(camera.rig.camera, {second_seen.x, second_seen.y});
  const Eigen::Vector3d first_in_map = first.camera_from_map.rotation().conjugate() * first_ray;
  const Eigen::Vector3d second_in_map = second.camera_from_map.rotation().conjugate() * second_ray;
  const double cosine = first_in_map.dot(second_in_map) / (first_in_map.norm() * second_in_map.norm());
  const double first_stereo = StereoParallaxCosine(camera, first_seen);
  const double second_stereo = StereoParallaxCosine(camera, second_seen);
  if (cosine > 0 && cosine < std::min(first_stereo, second_stereo)) {
    if (cosine > kMaxParallaxCosine && !first_seen.HasDepth() && !second_seen.HasDepth()) return std::nullopt;
    return TriangulateLinear(first.camera_from_map, second.camera_from_map, first_ray, second_ray);
  }
  if (first_stereo < second_stereo) return Unproject(camera, first, first_seen);
  if (second_stereo < 1.0) return Unproject(camera, second, second_seen);
  return std::nullopt;
}

bool IsGoodPoint(const MappingCamera& camera, const Map& map, const KeyFrame& first,
                 const Keypoint& first_seen, const KeyFrame& second, const Keypoint& second_seen,
                 const Eigen::Vector3d& position) {
  const std::vector<float>& inverse_sigma2 = map.scale_info().inverse_sigma2;
  return ReprojectsWell(camera, first, first_seen, inverse_sigma2[first_seen.octave], position) &&
         ReprojectsWell(camera, second, second_seen, inverse_sigma2[second_seen.octave], position) &&
         ScalesAgree(map, first, first_seen, second, second_seen, position);
}

bool IsFarEnough(const MappingCamera& camera, const KeyFrame& first, const KeyFrame& second,
                 double median_depth) {
  const double baseline = (first.Center() - second.Center()).norm();
  return camera.HasDepth() ? baseline >= camera.rig.baseline_m : baseline >= kMinBaselineShare * median_depth;
}

}  // namespace

std::vector<MapPointId> CreatePointsFromDepth(const MappingCamera& camera, double close_depth_m,
                                              KeyFrameId keyframe_id, Map* map) {
  std::vector<MapPointId> created;
  const KeyFrame& keyframe = *map->FindKeyFrame(keyframe_id);
  std::vector<std::pair<float, uint32_t>> by_depth;
  for (uint32_t i = 0; i < keyframe.features->size(); ++i) {
    const Keypoint& keypoint = keyframe.features->keypoints[i];
    if (keypoint.HasDepth()) by_depth.emplace_back(keypoint.depth, i);
  }
  std::sort(by_depth.begin(), by_depth.end());
  for (size_t n = 0; n < by_depth.size(); ++n) {
    const auto [depth, keypoint] = by_depth[n];
    if (n >= kMinDepthPoints && depth > close_depth_m) break;
    if (keyframe.points[keypoint].IsValid()) continue;
    const MapPointId id =
        map->AddPoint(Unproject(camera, keyframe, keyframe.features->keypoints[keypoint]), keyframe_id);
    map->AddObservation(id, keyframe_id, keypoint);
    map->UpdateAppearance(id);
    created.push_back(id);
  }
  return created;
}

std::vector<MapPointId> TriangulatePoints(const MappingCamera& camera, KeyFrameId keyframe_id,
                                          const std::vector<KeyFrameId>& neighbours, Map* map) {
  std::vector<MapPointId> created;
  const KeyFrame& first = *map->FindKeyFrame(keyframe_id);
  const double median_depth = MedianDepth(first, *map);
  if (median_depth <= 0) return created;
  for (const KeyFrameId neighbour : neighbours) {
    const KeyFrame& second = *map->FindKeyFrame(neighbour);
    if (!IsFarEnough(camera, first, second, median_depth)) continue;
    const PairGeometry geometry(camera, first, second, median_depth);
    for (const KeypointPair& pair : MatchAlongLines(camera, geometry, first, second, *map)) {
      const Keypoint& first_seen = first.features->keypoints[pair.first];
      const Keypoint& second_seen = second.features->keypoints[pair.second];
      const auto position = LocatePoint(camera, first, first_seen, second, second_seen);
      if (!position || !IsGoodPoint(camera, *map, first, first_seen, second, second_seen, *position))
        continue;
      const MapPointId id = map->AddPoint(*position, keyframe_id);
      map->AddObservation(id, keyframe_id, static_cast<uint32_t>(pair.first));
      map->AddObservation(id, neighbour, static_cast<uint32_t>(pair.second));
      map->UpdateAppearance(id);
      created.push_back(id);
    }
  }
  return created;
}

}  // namespace semmap
