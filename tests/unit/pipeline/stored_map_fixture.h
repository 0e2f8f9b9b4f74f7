#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "slam/pipeline/session.h"
#include "slam/pipeline/shared_map.h"
#include "tests/support/map_collector.h"
#include "tests/support/room_drive.h"
#include "tests/support/textured_room.h"
#include "tests/unit/pipeline/fake_map_store.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap::testing {

inline constexpr int kMapFrames = 24;
inline constexpr double kStep = 0.12;
// Of a pose against the truth, metres: the map's own error, and a little.
inline constexpr double kBound = 0.05;

inline SlamConfig SmallConfig() {
  SlamConfig config;
  config.orb.features = 800;
  config.deterministic = true;
  return config;
}

// Another lane: what the second vehicle drives.
inline SE3 Beside(const SE3& map_from_camera) {
  return map_from_camera * SE3(ExpSO3({0, 0.03, 0}), {0.07, -0.02, 0.03});
}

inline FrameInput BlackFrame(const CameraRig& rig, int index) {
  FrameInput frame;
  frame.sequence = static_cast<uint64_t>(index + 1);
  frame.timestamp = FromSeconds(0.1 * index);
  frame.image = cv::Mat::zeros(rig.camera.height, rig.camera.width, CV_8UC1);
  if (rig.sensor == SensorType::kStereo) frame.right = frame.image.clone();
  return frame;
}

inline MapCollector MakeCollector() {
  const SlamConfig config = SmallConfig();
  return {ScalePyramidInfo(config.orb.levels, config.orb.scale_factor), UndistortedBounds(SmallCamera())};
}

// The map that a first drive in stereo made, and the truth in its frame.
class StoredMapTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    made_ = new MapCollector(MakeCollector());
    auto session = Session::Create(SmallConfig(), SmallRig(SensorType::kStereo), made_, nullptr, vocabulary_);
    ASSERT_TRUE(session.ok()) << session.status();
    const std::vector<SE3> poses = GentleDrive(kMapFrames, kStep);
    for (int i = 0; i < kMapFrames; ++i) {
      ASSERT_TRUE((*session)->Track(SeeRoom(SmallRig(SensorType::kStereo), poses[i], i)).ok());
    }
    (*session)->Finish();
  }
  static void TearDownTestSuite() {
    delete made_;
    made_ = nullptr;
  }

  static SE3 MapFromWorld() { return GentleDrive(1, kStep).front().Inverse(); }

  std::unique_ptr<Session> Localizer(SensorType sensor, MapDeltaSink* sink) {
    auto map = made_->Restore();
    EXPECT_TRUE(map.ok()) << map.status();
    SessionStart start;
    start.localize = MakeMapSnapshot(*std::move(map), 0, 5, true, vocabulary_, PlaceQueryLimits());
    return *Session::Create(SmallConfig(), SmallRig(sensor), sink, nullptr, nullptr, nullptr,
                            std::move(start));
  }
  // The same map, of which next to nothing stays in memory.
  std::unique_ptr<Session> LocalizerWithoutMemory(SensorType sensor, MapDeltaSink* sink) {
    const SlamConfig config = SmallConfig();
    const PlaceDescriber describer(vocabulary_, ClassSet());
    const auto store = std::make_shared<FakeMapStore>(UndistortedBounds(SmallCamera()), 5);
    for (const MapDelta& delta : made_->deltas()) store->Apply(delta);
    SessionStart start;
    start.localize = std::make_shared<const StoredMap>(
        StoredMap::Reading{ScalePyramidInfo(config.orb.levels, config.orb.scale_factor), PointClassPolicy(),
                           describer},
        store->Core(describer), store, std::make_shared<MapPartCache>(size_t{100} << 10), 1);
    return *Session::Create(config, SmallRig(sensor), sink, nullptr, nullptr, nullptr, std::move(start));
  }
  std::unique_ptr<Session> Extender(MapDeltaSink* sink) {
    auto map = made_->Restore();
    EXPECT_TRUE(map.ok()) << map.status();
    return Extender(std::make_shared<SharedMap>(*std::move(map), made_->last_keyframe()), sink);
  }
  static std::unique_ptr<Session> Extender(std::shared_ptr<SharedMap> map, MapDeltaSink* sink,
                                           Executor* executor = nullptr) {
    SlamConfig config = SmallConfig();
    config.deterministic = executor == nullptr;
    SessionStart start;
    start.shared = std::move(map);
    return *Session::Create(config, SmallRig(SensorType::kStereo), sink, executor, vocabulary_, nullptr,
                            std::move(start));
  }

  static void ExpectAt(const FrameResult& result, const SE3& world_from_camera, double bound) {
    ASSERT_EQ(result.state, TrackingState::kTracking)
        << "frame " << result.sequence << ", failure " << static_cast<int>(result.failure);
    const SE3 error = result.map_from_camera->Inverse() * MapFromWorld() * world_from_camera;
    EXPECT_LT(error.translation().norm(), bound) << "frame " << result.sequence;
    EXPECT_LT(error.RotationAngle(), 0.01) << "frame " << result.sequence;
  }

  static inline const std::shared_ptr<const Vocabulary> vocabulary_ = RandomVocabulary(12, 5);
  static inline MapCollector* made_ = nullptr;
};

}  // namespace semmap::testing
