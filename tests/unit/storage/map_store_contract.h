#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "storage_test_support.h"

// What every backend must do, whatever lies under it: *_contract_test.cpp. A backend joins by a line in
// AllBackends.
namespace semmap::storage {

struct Backend {
  std::string name;
  // The configuration of a store in this directory; the same one again opens the same store.
  std::function<StorageConfig(const TempDir&)> config;
};

inline std::vector<Backend> AllBackends() {
  const auto normal = [](const TempDir& dir) { return ConfigFor(dir.File("maps.db")); };
  const auto full = [](const TempDir& dir) {
    StorageConfig config = ConfigFor(dir.File("\xC3\xBC maps?.db"));
    config.synchronous = "full";
    config.max_readers = 1;
    return config;
  };
  return {{"SqliteNormal", normal}, {"SqliteFull", full}};
}

inline std::string BackendName(const testing::TestParamInfo<Backend>& backend) { return backend.param.name; }

class MapStoreContract : public testing::TestWithParam<Backend> {
 protected:
  MapStoreContract() : config_(GetParam().config(dir_)), store_(OpenOrDie(config_)) {}

  void Reopen() {
    store_.reset();
    store_ = OpenOrDie(config_);
  }

  // A map with one session, whose deltas Apply numbers.
  void StartMap(const std::string& name = "town") {
    const absl::StatusOr<MapInfo> map = store_->CreateMap(MapNamed(name));
    ASSERT_TRUE(map.ok()) << map.status();
    map_ = map->id;
    const absl::StatusOr<SessionInfo> session = store_->StartSession(SessionOf(map_, "session-of-" + name));
    ASSERT_TRUE(session.ok()) << session.status();
    session_ = session->id;
    version_ = 0;
  }

  absl::Status Apply(MapDelta delta) {
    delta.version = version_ + 1;
    const absl::Status status = store_->Apply(map_, session_, delta);
    if (status.ok()) ++version_;
    return status;
  }

  // Keyframes 1 to 3 (2 and 3 children of 1) with 8 keypoints each, points 1 to 4, frames 0 to 5.
  MapDelta SmallDelta() {
    MapDelta delta;
    for (uint64_t id = 1; id <= 3; ++id) {
      delta.added_keyframes.push_back(KeyFrameWith(id, 8, {static_cast<double>(id), 0, 0}));
      if (id > 1) delta.added_keyframes.back().parent = KeyFrameId(1);
      delta.observations.push_back({KeyFrameId(id), std::vector<MapPointId>(8)});
    }
    for (uint64_t id = 1; id <= 4; ++id) {
      delta.upserted_points.push_back(
          PointAt(id, {10.0 * static_cast<double>(id), 1, -1}, static_cast<uint8_t>(id)));
      for (size_t k = 0; k < 2; ++k) delta.observations[k].point_of_keypoint[id] = MapPointId(id);
      delta.upserted_points.back().observation_count = 2;
    }
    for (uint64_t sequence = 0; sequence <= 5; ++sequence) {
      const KeyFrameId reference(1 + sequence / 2);
      delta.frames.push_back({sequence, static_cast<TimestampNs>(100 * sequence), reference,
                              SE3(Eigen::Quaterniond(1, 0.1, 0, 0), {0, static_cast<double>(sequence), 0})});
    }
    return delta;
  }

  void StartSmallMap() {
    StartMap();
    const absl::Status status = Apply(SmallDelta());
    ASSERT_TRUE(status.ok()) << status;
  }

  void ExpectRefused(const MapDelta& delta, absl::StatusCode code = absl::StatusCode::kInvalidArgument) {
    const absl::StatusOr<MapInfo> before = store_->GetMap(map_);
    const absl::Status status = Apply(delta);
    EXPECT_EQ(status.code(), code) << status;
    const absl::StatusOr<MapInfo> after = store_->GetMap(map_);
    EXPECT_EQ(before->version, after->version);
    EXPECT_EQ(before->keyframe_count, after->keyframe_count);
    EXPECT_EQ(before->point_count, after->point_count);
    EXPECT_EQ(Findings(*store_, map_), "");
  }

  TempDir dir_;
  StorageConfig config_;
  std::unique_ptr<MapStore> store_;
  MapId map_;
  SessionId session_;
  uint64_t version_ = 0;
};

}  // namespace semmap::storage
