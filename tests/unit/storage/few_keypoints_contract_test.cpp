#include <optional>
#include <vector>

#include "map_store_contract.h"

// What a store must do that is configured to keep few of a keyframe's keypoints.
namespace semmap::storage {
namespace {

class FewKeypoints : public MapStoreContract {
 protected:
  static constexpr size_t kKeypoints = 40;

  FewKeypoints() {
    config_.keyframe_keypoints = 10;
    Reopen();
    StartMap();
    KeyFrameRecord keyframe = KeyFrameWith(1, kKeypoints);
    features_ = keyframe.features;
    MapDelta delta;
    delta.added_keyframes.push_back(keyframe);
    Observe(&delta, 5, 1);
    EXPECT_TRUE(Apply(delta).ok());
  }

  // Point `id` is seen through keypoint `keypoint` from now on.
  void Observe(MapDelta* delta, size_t keypoint, uint64_t id) {
    sees_[keypoint] = MapPointId(id);
    delta->upserted_points.push_back(PointAt(id, {1, 1, 1}));
    delta->upserted_points.back().observation_count = 1;
    delta->observations = {{KeyFrameId(1), sees_, features_}};
  }

  // The keypoint of the frame through which the stored keyframe sees the point.
  std::optional<uint32_t> SeenThrough(uint64_t point) {
    const absl::StatusOr<KeyFrameEntry> keyframe = store_->GetKeyFrame(map_, KeyFrameId(1));
    const absl::StatusOr<KeyFrameObservations> seen = store_->GetObservations(map_, KeyFrameId(1));
    EXPECT_TRUE(keyframe.ok() && seen.ok());
    const FrameFeatures& stored = *keyframe->record.features;
    EXPECT_EQ(seen->point_of_keypoint.size(), stored.size());
    EXPECT_EQ(keyframe->keypoint_count, kKeypoints);
    for (size_t i = 0; i < stored.size(); ++i) {
      const uint32_t frame_index =
          stored.frame_index.empty() ? static_cast<uint32_t>(i) : stored.frame_index[i];
      EXPECT_TRUE(SameKeypoint(stored.keypoints[i], features_->keypoints[frame_index]));
      EXPECT_EQ(stored.descriptors[i], features_->descriptors[frame_index]);
      if (seen->point_of_keypoint[i] == MapPointId(point)) return frame_index;
    }
    return std::nullopt;
  }

  size_t StoredKeypoints() { return store_->GetKeyFrame(map_, KeyFrameId(1))->record.features->size(); }

  std::shared_ptr<const FrameFeatures> features_;
  std::vector<MapPointId> sees_ = std::vector<MapPointId>(kKeypoints);
};

TEST_P(FewKeypoints, AreChosenAndFoundAgain) {
  EXPECT_EQ(StoredKeypoints(), 10U);
  EXPECT_EQ(SeenThrough(1), 5U);
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(FewKeypoints, BecomeMoreWhenTheySeePoints) {
  for (uint64_t id = 2; id <= 30; ++id) {
    MapDelta delta;
    Observe(&delta, 40 - id, id);
    const absl::Status status = Apply(delta);
    ASSERT_TRUE(status.ok()) << status;
  }
  Reopen();
  for (uint64_t id = 2; id <= 30; ++id) EXPECT_EQ(SeenThrough(id), 40 - id);
  EXPECT_LT(StoredKeypoints(), kKeypoints);
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(FewKeypoints, MayBeObservedByWhoLoadedThem) {
  const absl::StatusOr<KeyFrameEntry> keyframe = store_->GetKeyFrame(map_, KeyFrameId(1));
  KeyFrameObservations loaded = *store_->GetObservations(map_, KeyFrameId(1));
  const uint32_t frame_index = keyframe->record.features->frame_index[9];
  loaded.point_of_keypoint[9] = MapPointId(2);
  for (const bool with_features : {true, false}) {
    MapDelta delta;
    delta.upserted_points = {PointAt(2, {1, 1, 1})};
    delta.upserted_points[0].observation_count = 1;
    delta.observations = {loaded};
    if (with_features) delta.observations[0].features = keyframe->record.features;
    const absl::Status status = Apply(delta);
    ASSERT_TRUE(status.ok()) << status;
    EXPECT_EQ(SeenThrough(2), frame_index);
    EXPECT_EQ(SeenThrough(1), 5U);
  }
}

TEST_P(FewKeypoints, AreNotObservedWithoutTheirFeatures) {
  MapDelta delta;
  for (size_t i = 0; i < kKeypoints; ++i) sees_[i] = MapPointId(1 + i);
  delta.observations = {{KeyFrameId(1), sees_}};
  ExpectRefused(delta);
  delta.observations = {{KeyFrameId(1), std::vector<MapPointId>(11)}};
  ExpectRefused(delta);
  delta.observations = {{KeyFrameId(1), std::vector<MapPointId>(kKeypoints), KeyFrameWith(1, 3).features}};
  ExpectRefused(delta);
}

INSTANTIATE_TEST_SUITE_P(Backends, FewKeypoints, testing::ValuesIn(AllBackends()), BackendName);

}  // namespace
}  // namespace semmap::storage
