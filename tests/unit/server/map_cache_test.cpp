#include "server/map_cache.h"

#include <atomic>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "server/error_reasons.h"
#include "slam/common/notification.h"

namespace semmap::server {
namespace {

// Keeps what it is given until it is told to run it.
class ManualExecutor : public Executor {
 public:
  void Schedule(std::function<void()> task) override { tasks_.push_back(std::move(task)); }
  void ScheduleLong(std::function<void()> task) override { Schedule(std::move(task)); }
  size_t waiting() const { return tasks_.size(); }
  void RunAll() {
    for (auto& task : std::exchange(tasks_, {})) task();
  }

 private:
  std::vector<std::function<void()>> tasks_;
};

// A map of which nothing matters but how large it is, and of which version.
class FakeMap : public MapInMemory {
 public:
  FakeMap(uint64_t version, size_t bytes) : MapInMemory(kNothing, kNowhere, version), bytes_(bytes) {}
  size_t memory_bytes() const override { return bytes_; }

 private:
  static inline const Map kNothing{ScalePyramidInfo(8, 1.2)};
  static inline const PlaceMemory kNowhere{nullptr, PlaceQueryLimits()};
  const size_t bytes_;
};

class MapCacheTest : public testing::Test {
 protected:
  static constexpr size_t kMapBytes = 100;

  MapCache::Loader Loader() {
    return [this](storage::MapId map, size_t max_bytes) -> absl::StatusOr<MapCache::Snapshot> {
      loaded_.push_back(map.value());
      if (failure_) return *failure_;
      if (max_bytes < kMapBytes) return absl::ResourceExhaustedError("too large");
      return std::make_shared<FakeMap>(version_, kMapBytes);
    };
  }

  storage::MapInfo Info(uint64_t id) const {
    storage::MapInfo info;
    info.id = storage::MapId(id);
    info.version = version_;
    return info;
  }

  // As if the caller waited.
  absl::StatusOr<MapCache::Snapshot> Get(MapCache& cache, uint64_t id) {
    std::optional<absl::StatusOr<MapCache::Snapshot>> answer;
    cache.Get(Info(id), [&](absl::StatusOr<MapCache::Snapshot> loaded) { answer = std::move(loaded); });
    threads_.RunAll();
    EXPECT_TRUE(answer.has_value());
    return answer.value_or(absl::InternalError("no answer"));
  }

  MapCache::Limits limits_{.max_bytes = 250, .min_reload_interval = absl::ZeroDuration()};
  ManualExecutor threads_;
  uint64_t version_ = 1;
  std::optional<absl::Status> failure_;
  std::vector<uint64_t> loaded_;
};

TEST_F(MapCacheTest, AMapIsLoadedOnceForAll) {
  MapCache cache(limits_, Loader(), &threads_);
  int answers = 0;
  for (int i = 0; i < 3; ++i) {
    cache.Get(Info(1), [&](absl::StatusOr<MapCache::Snapshot> loaded) { answers += loaded.ok() ? 1 : 0; });
  }
  EXPECT_EQ(answers, 0) << "nobody waits in the caller's thread";
  threads_.RunAll();
  EXPECT_EQ(answers, 3);
  cache.Get(Info(1), [&](absl::StatusOr<MapCache::Snapshot>) { ++answers; });
  EXPECT_EQ(answers, 4) << "at once";
  EXPECT_EQ(loaded_, std::vector<uint64_t>{1});
  EXPECT_EQ(cache.memory_bytes(), kMapBytes);
}

TEST_F(MapCacheTest, AMapThatChangedIsLoadedAnew) {
  MapCache cache(limits_, Loader(), &threads_);
  const auto first = Get(cache, 1);
  version_ = 2;
  // Loading takes at most a tenth of the time, so a while must pass, however short.
  auto second = Get(cache, 1);
  for (int i = 0; i < 10'000 && (*second)->version() != version_; ++i) {
    absl::SleepFor(absl::Milliseconds(1));
    second = Get(cache, 1);
  }
  EXPECT_EQ((*first)->version(), 1U) << "what is held stays as it was";
  EXPECT_EQ((*second)->version(), 2U);
  EXPECT_EQ(cache.memory_bytes(), 2 * kMapBytes) << "the old one is still held";
}

TEST_F(MapCacheTest, AMapThatChangesAllTheTimeIsNotLoadedAllTheTime) {
  limits_.min_reload_interval = absl::Hours(1);
  MapCache cache(limits_, Loader(), &threads_);
  ASSERT_TRUE(Get(cache, 1).ok());
  version_ = 2;
  EXPECT_EQ((*Get(cache, 1))->version(), 1U);
  EXPECT_EQ(loaded_.size(), 1U);
}

TEST_F(MapCacheTest, TheOneThatWasNotAskedForLongestMakesRoom) {
  MapCache cache(limits_, Loader(), &threads_);
  ASSERT_TRUE(Get(cache, 1).ok());
  ASSERT_TRUE(Get(cache, 2).ok());
  ASSERT_TRUE(Get(cache, 1).ok());
  ASSERT_TRUE(Get(cache, 3).ok());
  EXPECT_EQ(cache.memory_bytes(), 2 * kMapBytes);
  ASSERT_TRUE(Get(cache, 1).ok());
  EXPECT_EQ(loaded_, (std::vector<uint64_t>{1, 2, 3}));
  ASSERT_TRUE(Get(cache, 2).ok());
  EXPECT_EQ(loaded_, (std::vector<uint64_t>{1, 2, 3, 2}));
}

TEST_F(MapCacheTest, MapsInUseStayAndWhatDoesNotFitIsRefused) {
  MapCache cache(limits_, Loader(), &threads_);
  const auto first = Get(cache, 1);
  auto second = Get(cache, 2);
  EXPECT_EQ(ReasonOf(Get(cache, 3).status()), v1::ERROR_REASON_MAP_TOO_LARGE);
  EXPECT_TRUE(Get(cache, 1).ok());
  second = absl::CancelledError("done with it");
  EXPECT_TRUE(Get(cache, 3).ok());
}

TEST_F(MapCacheTest, WhereANewVersionDoesNotFitTheOldOneServes) {
  limits_.max_bytes = 150;
  MapCache cache(limits_, Loader(), &threads_);
  const auto held = Get(cache, 1);
  version_ = 2;
  const auto again = Get(cache, 1);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ((*again)->version(), 1U);
}

TEST_F(MapCacheTest, AFailureIsToldToAllAndTriedAgain) {
  MapCache cache(limits_, Loader(), &threads_);
  failure_ = absl::DataLossError("damaged");
  EXPECT_TRUE(absl::IsDataLoss(Get(cache, 1).status()));
  failure_.reset();
  EXPECT_TRUE(Get(cache, 1).ok());
}

TEST_F(MapCacheTest, WhoMayWaitWaits) {
  const auto threads = MakeThreadPool(1);
  MapCache cache(limits_, Loader(), threads.get());
  const auto loaded = cache.GetAndWait(Info(1));
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ((*loaded)->version(), 1U);
}

}  // namespace
}  // namespace semmap::server
