// A map that is larger than the memory for maps is searched all the same.
#include <algorithm>
#include <thread>

#include <gtest/gtest.h>

#include "server/error_reasons.h"
#include "server/map_cache.h"
#include "slam/pipeline/map_localizer.h"
#include "storage/map_loader.h"
#include "temporary_store.h"
#include "tests/support/ring_world.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap::server {
namespace {

using semmap::testing::DriveRing;
using semmap::testing::RandomVocabulary;
using semmap::testing::RingView;
using semmap::testing::RingWorld;

constexpr int kKeyFrames = 40;
constexpr double kStep = 0.13;

class MapMemoryTest : public ::testing::Test {
 protected:
  MapMemoryTest() {
    const storage::MapInfo map = *store_->CreateMap({"ring", 1, camera_.rig, true});
    const storage::SessionInfo session = *store_->StartSession({map.id, "s1", "car", 1, camera_.rig});
    MapDelta delta = DriveRing(world_, camera_, kKeyFrames, kStep, {}).TakeDelta();
    delta.version = 1;
    const absl::Status status = store_->Apply(map.id, session.id, delta);
    EXPECT_TRUE(status.ok()) << status;
    info_ = *store_->GetMap(map.id);
    whole_bytes_ = storage::LoadMap(*store_, map.id, RingWorld::ScaleInfo(), SIZE_MAX)->memory_bytes;
  }

  std::unique_ptr<MapCache> Cache(size_t max_bytes) {
    auto parts = std::make_shared<MapPartCache>(max_bytes);
    return std::make_unique<MapCache>(
        MapCache::Limits{max_bytes, max_bytes / 4, absl::Seconds(1)},
        MakeMapLoader(store_.get(), SlamConfig(), RandomVocabulary(12, 5), parts), threads_.get(), parts);
  }

  int FindAll(const MapSnapshot& map, int offset) const {
    int found = 0;
    for (int i = 0; i < kKeyFrames; i += 3) {
      const double angle = ((i + offset) % kKeyFrames + 0.4) * kStep;
      const RingView view = world_.View(camera_, RingWorld::WorldFromCamera(angle), 100);
      const FeatureGrid grid(camera_.bounds, view.features.keypoints);
      const auto located =
          MapLocalizer(RelocalizationConfig(), 1).Locate(map, camera_, {view.features, grid}, PlacePrior());
      EXPECT_TRUE(located.ok()) << located.status();
      found += located.ok() && located->found.has_value() ? 1 : 0;
    }
    return found;
  }

  TemporaryDirectory directory_;
  std::unique_ptr<storage::MapStore> store_ = OpenStoreIn(directory_);
  const std::unique_ptr<Executor> threads_ = MakeThreadPool(1);
  const RingWorld world_{1};
  const MappingCamera camera_ = RingWorld::Camera(SensorType::kStereo);
  storage::MapInfo info_;
  size_t whole_bytes_ = 0;
};

TEST_F(MapMemoryTest, AMapThatIsTooLargeForMemoryIsSearchedByParts) {
  const size_t limit = whole_bytes_ / 3;
  const auto cache = Cache(limit);
  const auto map = cache->GetAndWait(info_);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_LT((*map)->memory_bytes(), limit);
  const int found = FindAll(**map, 0);
  EXPECT_GE(found, 12);
  EXPECT_LE(cache->memory_bytes(), limit);
  EXPECT_GT(cache->memory_bytes(), limit / 2) << "what there is of memory is used";
  EXPECT_EQ(FindAll(**map, 0), found);
}

TEST_F(MapMemoryTest, ManyShareOneMapAndOneLimit) {
  const size_t limit = whole_bytes_ / 3;
  const auto cache = Cache(limit);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      const auto map = cache->GetAndWait(info_);
      ASSERT_TRUE(map.ok()) << map.status();
      EXPECT_GE(FindAll(**map, 7 * t), 12);
      EXPECT_LE(cache->memory_bytes(), limit);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(MapMemoryTest, AnOutlineThatDoesNotFitIsRefused) {
  const auto cache = Cache(20'000);
  EXPECT_EQ(ReasonOf(cache->GetAndWait(info_).status()), v1::ERROR_REASON_MAP_TOO_LARGE);
}

}  // namespace
}  // namespace semmap::server
