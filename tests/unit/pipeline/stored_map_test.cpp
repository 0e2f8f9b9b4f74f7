// A map of which parts are read as they are needed answers what the whole map in memory answers.
#include "slam/pipeline/stored_map.h"

#include <thread>

#include <gtest/gtest.h>

#include "slam/pipeline/map_localizer.h"
#include "tests/unit/pipeline/fake_map_store.h"
#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

constexpr size_t kPlenty = size_t{1} << 30;

class StoredMapTest : public ::testing::TestWithParam<SensorType> {
 protected:
  static constexpr uint64_t kVersion = 7;

  StoredMapTest()
      : world_(1),
        camera_(RingWorld::Camera(GetParam())),
        map_(DriveRing(world_, camera_, 40, kRingStep, {})),
        places_(Remember(map_)),
        whole_(map_, places_, kVersion),
        store_(FakeMapStore::Of(&map_, camera_.bounds, kVersion)) {
    Open(kPlenty);
  }

  void Open(size_t max_part_bytes) {
    const PlaceDescriber describer(RandomVocabulary(12, 5), ClassSet());
    parts_ = std::make_shared<MapPartCache>(max_part_bytes);
    stored_.emplace(StoredMap::Reading{RingWorld::ScaleInfo(), PointClassPolicy(), describer},
                    store_->Core(describer), store_, parts_, 1);
  }

  MapLocalization Find(const MapSnapshot& map, const RingView& view, const PlacePrior& prior = {}) const {
    const FeatureGrid grid(camera_.bounds, view.features.keypoints);
    const auto found =
        MapLocalizer(RelocalizationConfig(), 1).Locate(map, camera_, {view.features, grid}, prior);
    EXPECT_TRUE(found.ok()) << found.status();
    return found.value_or(MapLocalization());
  }
  RingView ViewAt(double steps, uint32_t seed) const {
    const SE3 aside(ExpSO3({0.01, 0.05, 0}), {0.4, 0.1, 0.2});
    return world_.View(camera_, RingWorld::WorldFromCamera(steps * kRingStep) * aside, seed);
  }

  void ExpectSameAnswers() {
    for (int i = 0; i < 20; ++i) {
      const RingView view = ViewAt(3 + 1.7 * i, static_cast<uint32_t>(100 + i));
      const MapLocalization expected = Find(whole_, view);
      const MapLocalization found = Find(*stored_, view);
      ASSERT_EQ(found.failure, expected.failure) << i;
      ASSERT_TRUE(found.found.has_value()) << i;
      EXPECT_EQ(found.candidates, expected.candidates);
      EXPECT_EQ(found.matches, expected.matches);
      EXPECT_EQ(found.rival_inliers, expected.rival_inliers);
      EXPECT_EQ(found.found->fix.matches, expected.found->fix.matches);
      const SE3 difference = found.found->fix.camera_from_map * expected.found->fix.camera_from_map.Inverse();
      EXPECT_LT(difference.translation().norm(), 1e-9) << i;
      EXPECT_LT(difference.RotationAngle(), 1e-9) << i;
      EXPECT_EQ(KeyFramesSeeing(*stored_, *found.found, 5), KeyFramesSeeing(whole_, *expected.found, 5));
    }
  }

  RingWorld world_;
  MappingCamera camera_;
  Map map_;
  PlaceMemory places_;
  MapInMemory whole_;
  std::shared_ptr<FakeMapStore> store_;
  std::shared_ptr<MapPartCache> parts_;
  std::optional<StoredMap> stored_;
};

void ExpectSameView(const LocalMapView& view, const LocalMapView& expected) {
  EXPECT_EQ(view.version, expected.version);
  EXPECT_EQ(view.map_keyframes, expected.map_keyframes);
  EXPECT_EQ(view.ids, expected.ids);
  EXPECT_EQ(view.positions, expected.positions);
  EXPECT_EQ(view.normals, expected.normals);
  EXPECT_EQ(view.min_distances, expected.min_distances);
  EXPECT_EQ(view.max_distances, expected.max_distances);
  EXPECT_EQ(view.descriptors, expected.descriptors);
  EXPECT_EQ(view.observation_counts, expected.observation_counts);
  EXPECT_EQ(view.classes, expected.classes);
  ASSERT_EQ(view.keyframes.size(), expected.keyframes.size());
  for (size_t i = 0; i < view.keyframes.size(); ++i) {
    EXPECT_EQ(view.keyframes[i].id, expected.keyframes[i].id);
    EXPECT_EQ(view.keyframes[i].point_of_keypoint, expected.keyframes[i].point_of_keypoint);
    EXPECT_EQ(view.keyframes[i].features->descriptors, expected.keyframes[i].features->descriptors);
  }
}

TEST_P(StoredMapTest, ViewsAreThoseOfTheWholeMap) {
  LocalMapViewLimits few;
  few.neighbours = 4;
  few.keyframes = 2;
  for (const KeyFrameId id : SortedKeyFrames(map_)) {
    for (const LocalMapViewLimits& limits : {LocalMapViewLimits(), few}) {
      const auto view = stored_->ViewAround(id, limits);
      ASSERT_TRUE(view.ok()) << view.status();
      ExpectSameView(**view, **whole_.ViewAround(id, limits));
    }
    const auto candidate = stored_->Candidate(id);
    ASSERT_TRUE(candidate.ok() && candidate->has_value());
    ExpectSameView(*(*candidate)->view, *(**whole_.Candidate(id)).view);
    EXPECT_EQ(*(*candidate)->nodes, *places_.NodesOf(id));
  }
  EXPECT_EQ(stored_->keyframe_count(), map_.keyframes().size());
}

TEST_P(StoredMapTest, AnswersAreThoseOfTheWholeMap) { ExpectSameAnswers(); }

TEST_P(StoredMapTest, AnswersAreTheSameWithoutRoomToKeepAnything) {
  Open(1);
  ExpectSameAnswers();
  EXPECT_EQ(parts_->memory_bytes(), 0U);
}

TEST_P(StoredMapTest, WhatWasReadIsNotReadAgain) {
  const RingView view = ViewAt(10.3, 1);
  Find(*stored_, view);
  const int reads = store_->reads();
  EXPECT_GT(reads, 0);
  Find(*stored_, view);
  EXPECT_EQ(store_->reads(), reads);
  EXPECT_LT(parts_->memory_bytes(), size_t{40} << 20);
}

TEST_P(StoredMapTest, AnotherPlaceIsNotFoundAndHardlyAnythingIsRead) {
  const RingView view = RingWorld(2).View(camera_, RingWorld::WorldFromCamera(1), 5);
  const MapLocalization expected = Find(whole_, view);
  const MapLocalization found = Find(*stored_, view);
  EXPECT_FALSE(found.found.has_value());
  EXPECT_EQ(found.failure, expected.failure);
}

TEST_P(StoredMapTest, AViewIsOfOneVersion) {
  const KeyFrameId id = SortedKeyFrames(map_)[20];
  ASSERT_TRUE(stored_->ViewAround(SortedKeyFrames(map_)[10], LocalMapViewLimits()).ok());
  const Eigen::Vector3d shift(100, 0, 0);
  store_->Move(shift);
  // Some of what it needs is in memory, of the old version.
  const auto view = stored_->ViewAround(id, LocalMapViewLimits());
  ASSERT_TRUE(view.ok()) << view.status();
  const auto old_view = *whole_.ViewAround(id, LocalMapViewLimits());
  EXPECT_EQ((*view)->version, kVersion + 1);
  ASSERT_EQ((*view)->ids, old_view->ids);
  for (size_t i = 0; i < old_view->size(); ++i)
    EXPECT_LT(((*view)->positions[i] - old_view->positions[i] - shift).norm(), 1e-9);
  const RingView image = ViewAt(10.3, 1);
  const auto before = Find(whole_, image);
  const auto after = Find(*stored_, image);
  ASSERT_TRUE(after.found.has_value() && before.found.has_value());
  EXPECT_NEAR((after.found->fix.camera_from_map.Inverse().translation() -
               before.found->fix.camera_from_map.Inverse().translation())
                  .norm(),
              100, 0.02);
}

TEST_P(StoredMapTest, WhatHasGoneIsLeftOut) {
  const KeyFrameId gone = SortedKeyFrames(map_)[10];
  store_->Remove(gone);
  EXPECT_EQ(*stored_->ViewAround(gone, LocalMapViewLimits()), nullptr);
  EXPECT_FALSE(stored_->Candidate(gone)->has_value());
  EXPECT_TRUE(Find(*stored_, ViewAt(10.3, 1)).found.has_value()) << "by its neighbours";
}

TEST_P(StoredMapTest, AStoreThatCannotBeReadIsToldOf) {
  store_->Fail(absl::DataLossError("damaged"));
  const RingView view = ViewAt(10.3, 1);
  const FeatureGrid grid(camera_.bounds, view.features.keypoints);
  const auto found =
      MapLocalizer(RelocalizationConfig(), 1).Locate(*stored_, camera_, {view.features, grid}, PlacePrior());
  EXPECT_TRUE(absl::IsDataLoss(found.status())) << found.status();
}

TEST_P(StoredMapTest, ManyThreadsGetTheSameAnswers) {
  Open(size_t{200} << 10);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 8; ++i) {
        const RingView view = ViewAt(3 + 4 * ((i + t) % 8), 100);
        const MapLocalization expected = Find(whole_, view);
        const MapLocalization found = Find(*stored_, view);
        ASSERT_EQ(found.found.has_value(), expected.found.has_value());
        if (!found.found) continue;
        EXPECT_EQ(found.found->fix.matches, expected.found->fix.matches);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

INSTANTIATE_TEST_SUITE_P(Sensors, StoredMapTest, ::testing::Values(SensorType::kMono, SensorType::kStereo));

}  // namespace
}  // namespace semmap
