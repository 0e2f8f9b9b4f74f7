#include "slam/pipeline/local_bundle.h"

#include <algorithm>
#include <unordered_map>

namespace semmap {
namespace {

constexpr int kMinSharedPoints = 15;

// A bundle problem with what its indices stand for in the map.
class Window {
 public:
  Window(const ProjectionModel& model, Map* map) : map_(map) { problem_.model = model; }

  void AddCamera(KeyFrameId id, bool fixed) {
    camera_index_.emplace(id, static_cast<int>(cameras_.size()));
    cameras_.push_back(id);
    problem_.cameras.push_back({map_->FindKeyFrame(id)->camera_from_map, fixed});
  }
  bool HasCamera(KeyFrameId id) const { return camera_index_.contains(id); }

  void AddPointsOf(KeyFrameId id) {
    for (const MapPointId point : map_->FindKeyFrame(id)->points) {
      if (!point.IsValid() || !point_index_.emplace(point, static_cast<int>(points_.size())).second) continue;
      points_.push_back(point);
      problem_.points.push_back(map_->FindPoint(point)->position_in_map);
    }
  }

  // The keyframes outside that see most of the window's points.
  void AddRim(size_t limit) {
    std::unordered_map<KeyFrameId, int, IdHash> seen;
    for (const MapPointId point : points_) {
      for (const Observation& observation : map_->FindPoint(point)->observations) {
        if (!HasCamera(observation.keyframe)) ++seen[observation.keyframe];
      }
    }
    std::vector<std::pair<int, KeyFrameId>> ranked;
    for (const auto& [id, count] : seen) ranked.emplace_back(-count, id);
    std::sort(ranked.begin(), ranked.end());
    for (size_t i = 0; i < std::min(limit, ranked.size()); ++i) AddCamera(ranked[i].second, true);
  }

  void AddObservations() {
    for (size_t i = 0; i < points_.size(); ++i) {
      for (const Observation& observation : map_->FindPoint(points_[i])->observations) {
        const auto camera = camera_index_.find(observation.keyframe);
        if (camera == camera_index_.end()) continue;
        const Keypoint& keypoint =
            map_->FindKeyFrame(observation.keyframe)->features->keypoints[observation.keypoint];
        const double inverse_sigma2 = map_->scale_info().inverse_sigma2[keypoint.octave];
        problem_.observations.push_back({camera->second,
                                         static_cast<int>(i),
                                         {keypoint.x, keypoint.y, keypoint.right_x, inverse_sigma2},
                                         false});
      }
    }
  }

  // Something has to hold the window in place. One camera does: the scale of a monocular window is free then, but the
  // solver's damping keeps it, and two fixed cameras would keep the error of their own distance for ever.
  void FixOne() {
    const auto is_fixed = [](const BundleCamera& camera) { return camera.fixed; };
    if (std::any_of(problem_.cameras.begin(), problem_.cameras.end(), is_fixed)) return;
    const auto oldest = std::min_element(cameras_.begin(), cameras_.end());
    problem_.cameras[static_cast<size_t>(oldest - cameras_.begin())].fixed = true;
  }

  BundleSummary Solve(const BundleOptions& options) {
    const BundleSummary summary = AdjustBundle(options, &problem_);
    WriteBack();
    return summary;
  }

 private:
  void WriteBack() {
    for (size_t i = 0; i < cameras_.size(); ++i) {
      if (!problem_.cameras[i].fixed) map_->SetPose(cameras_[i], problem_.cameras[i].camera_from_map);
    }
    for (size_t i = 0; i < points_.size(); ++i) map_->SetPosition(points_[i], problem_.points[i]);
    for (const BundleObservation& observation : problem_.observations) {
      if (observation.outlier)
        map_->RemoveObservation(points_[observation.point], cameras_[observation.camera]);
    }
    for (const MapPointId point : points_) map_->UpdateViewing(point);
  }

  Map* map_;
  BundleProblem problem_;
  std::vector<KeyFrameId> cameras_;
  std::vector<MapPointId> points_;
  std::unordered_map<KeyFrameId, int, IdHash> camera_index_;
  std::unordered_map<MapPointId, int, IdHash> point_index_;
};

BundleOptions MakeOptions(const MappingConfig& config, const std::atomic<bool>* stop) {
  BundleOptions options;
  options.first_iterations = config.bundle_iterations;
  options.second_iterations = config.bundle_iterations_refined;
  options.stop = stop;
  return options;
}

}  // namespace

BundleSummary AdjustLocalMap(const MappingConfig& config, const ProjectionModel& model, KeyFrameId keyframe,
                             const std::atomic<bool>* stop, Map* map) {
  Window window(model, map);
  const auto limit = static_cast<size_t>(config.max_local_keyframes);
  std::vector<KeyFrameId> free = {keyframe};
  for (const CovisibleKeyFrame& neighbour : map->BestCovisible(keyframe, limit - 1, kMinSharedPoints)) {
    free.push_back(neighbour.id);
  }
  for (const KeyFrameId id : free) window.AddCamera(id, !map->FindKeyFrame(id)->parent.IsValid());
  for (const KeyFrameId id : free) window.AddPointsOf(id);
  window.AddRim(static_cast<size_t>(config.max_fixed_keyframes));
  window.FixOne();
  window.AddObservations();
  return window.Solve(MakeOptions(config, stop));
}

BundleSummary AdjustWholeMap(const MappingConfig& config, const ProjectionModel& model, Map* map) {
  Window window(model, map);
  std::vector<KeyFrameId> all;
  for (const auto& [id, keyframe] : map->keyframes()) all.push_back(id);
  std::sort(all.begin(), all.end());
  for (const KeyFrameId id : all) window.AddCamera(id, !map->FindKeyFrame(id)->parent.IsValid());
  for (const KeyFrameId id : all) window.AddPointsOf(id);
  window.AddObservations();
  BundleOptions options = MakeOptions(config, nullptr);
  options.second_iterations = 20;
  return window.Solve(options);
}

}  // namespace semmap
