#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slam/map/map.h"
#include "slam/map/map_parts.h"
#include "slam/pipeline/stored_map.h"

namespace semmap::testing {

// A store in memory: the records of one map, at a version that can be made to grow.
class FakeMapStore : public MapPartSource, public MapPartReader {
 public:
  FakeMapStore(const ImageBounds& bounds, uint64_t version) : bounds_(bounds), version_(version) {}

  // All that the map says has changed.
  static std::shared_ptr<FakeMapStore> Of(Map* map, const ImageBounds& bounds, uint64_t version) {
    auto store = std::make_shared<FakeMapStore>(bounds, version);
    store->Apply(map->TakeDelta());
    return store;
  }

  void Apply(const MapDelta& delta) {
    for (const KeyFrameRecord& keyframe : delta.added_keyframes) keyframes_[keyframe.id].record = keyframe;
    for (const KeyFramePose& moved : delta.moved_keyframes)
      keyframes_[moved.id].record.map_from_camera = moved.map_from_camera;
    for (const MapPointRecord& point : delta.upserted_points) points_[point.id] = point;
    for (const KeyFrameObservations& seen : delta.observations)
      keyframes_[seen.id].observations = seen.point_of_keypoint;
    for (const RemovedKeyFrame& removed : delta.removed_keyframes) keyframes_.erase(removed.removed);
    for (const MapPointId id : delta.removed_points) points_.erase(id);
  }

  // What OpenMap would make of it.
  StoredMap::Core Core(const PlaceDescriber& describer) const {
    StoredMap::Core core;
    core.version = version_;
    core.outline = Outline();
    core.places.emplace(describer.vocabulary(), PlaceQueryLimits());
    std::vector<std::pair<KeyFrameId, BagOfWords>> bags;
    for (const auto& [id, keyframe] : keyframes_)
      bags.emplace_back(id, describer.BagOf(describer.WordsOf(*keyframe.record.features)));
    core.places->AddAll(std::move(bags));
    return core;
  }

  MapOutline Outline() const {
    MapOutlineBuilder builder(keyframes_.size(), points_.rbegin()->first);
    for (const auto& [id, keyframe] : keyframes_) {
      std::vector<MapPointId> seen = keyframe.observations;
      std::erase(seen, MapPointId());
      EXPECT_TRUE(builder.Add(id, keyframe.record.map_from_camera, seen).ok());
    }
    return std::move(builder).Finish();
  }

  absl::Status Read(absl::FunctionRef<absl::Status(MapPartReader&)> read) override {
    if (!failure_.ok()) return failure_;
    return read(*this);
  }
  uint64_t version() const override { return version_; }
  absl::StatusOr<std::optional<StoredKeyFrame>> ReadKeyFrame(KeyFrameId id) override {
    ++reads_;
    const auto found = keyframes_.find(id);
    if (found == keyframes_.end()) return std::optional<StoredKeyFrame>();
    StoredKeyFrame stored = found->second;
    stored.bounds = bounds_;
    return std::optional<StoredKeyFrame>(std::move(stored));
  }
  absl::Status ReadPoints(MapPointId first, MapPointId last,
                          absl::FunctionRef<void(const MapPointRecord&)> visit) override {
    ++reads_;
    for (auto point = points_.lower_bound(first); point != points_.end() && point->first <= last; ++point)
      visit(point->second);
    return absl::OkStatus();
  }

  int reads() const { return reads_; }
  void Fail(absl::Status failure) { failure_ = std::move(failure); }
  // A later version, in which all is further on.
  void Move(const Eigen::Vector3d& shift) {
    ++version_;
    for (auto& [id, keyframe] : keyframes_) {
      SE3& pose = keyframe.record.map_from_camera;
      pose = SE3(pose.rotation(), pose.translation() + shift);
    }
    for (auto& [id, point] : points_) point.position_in_map += shift;
  }
  void Remove(KeyFrameId id) {
    ++version_;
    keyframes_.erase(id);
  }

 private:
  const ImageBounds bounds_;
  uint64_t version_;
  std::map<KeyFrameId, StoredKeyFrame> keyframes_;
  std::map<MapPointId, MapPointRecord> points_;
  std::atomic<int> reads_ = 0;
  absl::Status failure_;
};

}  // namespace semmap::testing
