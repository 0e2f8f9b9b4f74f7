#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include "slam/map/map_delta.h"
#include "storage/appearance_codec.h"
#include "storage/feature_codec.h"

namespace semmap::storage {

// What a map should be after some deltas, kept in memory.
struct ModelMap {
  std::map<uint64_t, KeyFrameRecord> keyframes;
  std::map<uint64_t, std::vector<MapPointId>> observations;
  std::map<uint64_t, MapPointRecord> points;
  std::map<uint64_t, FramePose> frames;
};

// Drives a random but consistent map (observations refer to what exists, counts agree) and tells each step as
// a delta. The model is changed directly, not by applying the deltas: it is what they must lead to.
class DeltaGenerator {
 public:
  explicit DeltaGenerator(uint32_t seed, size_t max_keypoints = 60)
      : random_(seed), max_keypoints_(max_keypoints) {}

  MapDelta Next() {
    delta_ = MapDelta();
    delta_.version = ++version_;
    moved_.clear();
    touched_points_.clear();
    touched_keyframes_.clear();
    if (Chance(0.02)) Reset();
    std::vector<KeyFrameId> added;
    if (model_.keyframes.empty() || Chance(0.8)) added.push_back(AddKeyFrame());
    MoveSome();
    ChangePoints();
    if (Chance(0.3)) RemovePoints();
    if (Chance(0.3)) CullKeyFrame(added);
    AddFrames();
    WriteDelta(added);
    return delta_;
  }

  const ModelMap& model() const { return model_; }

 private:
  bool Chance(double probability) { return std::bernoulli_distribution(probability)(random_); }
  size_t Below(size_t limit) { return std::uniform_int_distribution<size_t>(0, limit - 1)(random_); }
  double Real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  float Float(double low, double high) { return static_cast<float>(Real(low, high)); }

  SE3 RandomPose() {
    const Eigen::Quaterniond rotation(Real(-1, 1), Real(-1, 1), Real(-1, 1), Real(0.1, 1));
    return {rotation, {Real(-20, 20), Real(-2, 2), Real(-20, 20)}};
  }

  template <typename Container>
  auto& Any(Container& container) {
    return std::next(container.begin(), static_cast<std::ptrdiff_t>(Below(container.size())))->second;
  }

  void Reset() {
    delta_.reset = true;
    model_ = ModelMap();
  }

  std::shared_ptr<const FrameFeatures> RandomFeatures() {
    auto features = std::make_shared<FrameFeatures>();
    const size_t count = Below(max_keypoints_ + 1);
    const bool with_depth = Chance(0.5);
    for (size_t i = 0; i < count; ++i) {
      const bool has_depth = with_depth && Chance(0.6);
      features->keypoints.push_back(
          AsStored({Float(0, 1240), Float(0, 375), has_depth ? Float(0, 1240) : -1.0F,
                    has_depth ? Float(1, 80) : -1.0F, Float(0, 6.28), static_cast<uint8_t>(Below(8)),
                    static_cast<uint8_t>(Below(23))}));
      features->descriptors.push_back({{random_(), random_(), random_(), random_()}});
    }
    return features;
  }

  KeyFrameId AddKeyFrame() {
    KeyFrameRecord keyframe;
    keyframe.id = KeyFrameId(next_keyframe_++);
    keyframe.sequence = next_sequence_;
    keyframe.timestamp = static_cast<TimestampNs>(100 * next_sequence_);
    keyframe.map_from_camera = RandomPose();
    if (!model_.keyframes.empty()) keyframe.parent = Any(model_.keyframes).id;
    keyframe.features = RandomFeatures();
    model_.observations[keyframe.id.value()].resize(keyframe.features->size());
    touched_keyframes_.insert(keyframe.id.value());
    model_.keyframes[keyframe.id.value()] = keyframe;
    for (size_t i = 0; i < keyframe.features->size() / 2; ++i) {
      const MapPointId point =
          model_.points.empty() || Chance(0.3) ? AddPoint(keyframe) : Any(model_.points).id;
      Observe(keyframe.id, i, point);
    }
    return keyframe.id;
  }

  MapPointId AddPoint(const KeyFrameRecord& keyframe) {
    MapPointRecord point;
    point.id = MapPointId(next_point_++);
    point.position_in_map =
        keyframe.map_from_camera * Eigen::Vector3d(Real(-10, 10), Real(-3, 3), Real(1, 30));
    point.normal = Eigen::Vector3f::UnitZ();
    point.min_distance = Float(0.5, 2);
    point.max_distance = Float(10, 50);
    point.descriptor.words = {random_(), random_(), random_(), random_()};
    point.reference_keyframe = keyframe.id;
    point.first_seen = point.last_seen = keyframe.timestamp;
    Vote(&point);
    model_.points[point.id.value()] = AsStored(point);
    return point.id;
  }

  void Vote(MapPointRecord* point) {
    point->votes.push_back({static_cast<uint8_t>(Below(23)), static_cast<uint32_t>(1 + Below(1000))});
    if (point->votes.size() > 5) point->votes.clear();
    point->semantic_class = point->votes.empty() ? 255 : point->votes.front().semantic_class;
    point->class_confidence = Float(0, 1);
  }

  void Observe(KeyFrameId keyframe, size_t keypoint, MapPointId point) {
    std::vector<MapPointId>& seen = model_.observations[keyframe.value()];
    if (seen[keypoint].IsValid() || std::count(seen.begin(), seen.end(), point) > 0) return;
    seen[keypoint] = point;
    MapPointRecord& record = model_.points[point.value()];
    ++record.observation_count;
    const TimestampNs time = model_.keyframes[keyframe.value()].timestamp;
    record.first_seen = std::min(record.first_seen, time);
    record.last_seen = std::max(record.last_seen, time);
    touched_points_.insert(point.value());
    touched_keyframes_.insert(keyframe.value());
  }

  void MoveSome() {
    for (size_t i = 0; i < 3; ++i) {
      KeyFrameRecord& keyframe = Any(model_.keyframes);
      keyframe.map_from_camera =
          Chance(0.2) ? RandomPose() : SE3::Exp(Vector6d::Constant(0.01)) * keyframe.map_from_camera;
      moved_.insert(keyframe.id.value());
    }
  }

  void ChangePoints() {
    for (size_t i = 0; i < 10 && !model_.points.empty(); ++i) {
      MapPointRecord& point = Any(model_.points);
      point.position_in_map += Eigen::Vector3d::Constant(Chance(0.1) ? Real(-5, 5) : Real(-0.02, 0.02));
      Vote(&point);
      touched_points_.insert(point.id.value());
    }
  }

  void Forget(MapPointId point) {
    for (auto& [keyframe, seen] : model_.observations) {
      for (MapPointId& id : seen) {
        if (id != point) continue;
        id = MapPointId();
        touched_keyframes_.insert(keyframe);
      }
    }
    model_.points.erase(point.value());
    touched_points_.erase(point.value());
    delta_.removed_points.push_back(point);
  }

  void RemovePoints() {
    for (size_t i = 0; i < 3 && !model_.points.empty(); ++i) Forget(Any(model_.points).id);
  }

  // The parent inherits frames and children; of the children some are moved by the delta, some left to the
  // store.
  void CullKeyFrame(const std::vector<KeyFrameId>& added) {
    const KeyFrameRecord victim = Any(model_.keyframes);
    const bool is_new = std::count(added.begin(), added.end(), victim.id) > 0;
    if (is_new || !model_.keyframes.contains(victim.parent.value())) return;
    const SE3 heir_from_removed =
        model_.keyframes[victim.parent.value()].map_from_camera.Inverse() * victim.map_from_camera;
    for (auto& [id, keyframe] : model_.keyframes) {
      if (keyframe.parent != victim.id) continue;
      keyframe.parent = victim.parent;
      if (Chance(0.5)) moved_.insert(id);
    }
    for (auto& [sequence, frame] : model_.frames) {
      if (frame.reference_keyframe != victim.id) continue;
      frame.reference_keyframe = victim.parent;
      frame.keyframe_from_camera = heir_from_removed * frame.keyframe_from_camera;
    }
    const std::vector<MapPointId> seen = model_.observations[victim.id.value()];
    model_.observations.erase(victim.id.value());
    model_.keyframes.erase(victim.id.value());
    moved_.erase(victim.id.value());
    touched_keyframes_.erase(victim.id.value());
    delta_.removed_keyframes.push_back({victim.id, victim.parent, heir_from_removed});
    for (const MapPointId point : seen) {
      if (point.IsValid()) LoseObserver(point);
    }
    // Others may have named it as their reference without being seen by it any more.
    for (auto& [id, point] : model_.points) {
      if (point.reference_keyframe != victim.id) continue;
      point.reference_keyframe = victim.parent;
      touched_points_.insert(id);
    }
  }

  void LoseObserver(MapPointId id) {
    MapPointRecord& point = model_.points[id.value()];
    if (--point.observation_count == 0) {
      Forget(id);
    } else {
      touched_points_.insert(id.value());
    }
  }

  void AddFrames() {
    const size_t count = 1 + Below(4);
    for (size_t i = 0; i < count; ++i) {
      // Now and then a frame comes again with a better pose.
      const bool again = Chance(0.1) && !model_.frames.empty();
      FramePose frame;
      frame.sequence = again ? Any(model_.frames).sequence : next_sequence_++;
      frame.timestamp = static_cast<TimestampNs>(100 * frame.sequence);
      frame.reference_keyframe = Any(model_.keyframes).id;
      frame.keyframe_from_camera = RandomPose();
      model_.frames[frame.sequence] = frame;
      delta_.frames.push_back(frame);
    }
  }

  void WriteDelta(const std::vector<KeyFrameId>& added) {
    for (const KeyFrameId id : added) {
      delta_.added_keyframes.push_back(model_.keyframes[id.value()]);
      moved_.erase(id.value());
    }
    for (const uint64_t id : moved_) {
      const KeyFrameRecord& keyframe = model_.keyframes[id];
      delta_.moved_keyframes.push_back({keyframe.id, keyframe.map_from_camera, keyframe.parent});
    }
    for (const uint64_t id : touched_points_) delta_.upserted_points.push_back(model_.points[id]);
    for (const uint64_t id : touched_keyframes_) {
      delta_.observations.push_back({KeyFrameId(id), model_.observations[id]});
    }
  }

  std::mt19937_64 random_;
  const size_t max_keypoints_;
  ModelMap model_;
  MapDelta delta_;
  std::set<uint64_t> moved_;
  std::set<uint64_t> touched_points_;
  std::set<uint64_t> touched_keyframes_;
  uint64_t version_ = 0;
  uint64_t next_keyframe_ = 1;
  uint64_t next_point_ = 1;
  uint64_t next_sequence_ = 0;
};

}  // namespace semmap::storage
