#pragma once

#include <bit>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "slam/map/map_delta.h"
#include "storage/appearance_codec.h"
#include "storage/feature_codec.h"
#include "storage/map_store.h"
#include "tests/support/temporary_directory.h"

namespace semmap::storage {

using TempDir = semmap::TemporaryDirectory;

inline StorageConfig ConfigFor(const std::string& path) {
  StorageConfig config;
  config.uri = "sqlite://" + path;
  config.cache_mb = 4;
  return config;
}

inline std::unique_ptr<MapStore> OpenOrDie(const StorageConfig& config) {
  absl::StatusOr<std::unique_ptr<MapStore>> store = OpenMapStore(config);
  EXPECT_TRUE(store.ok()) << store.status();
  return store.ok() ? *std::move(store) : nullptr;
}

inline CameraRig StereoRig() {
  CameraRig rig;
  rig.sensor = SensorType::kStereo;
  rig.camera.width = 1241;
  rig.camera.height = 376;
  rig.camera.fx = rig.camera.fy = 718.856;
  rig.camera.cx = 607.1928;
  rig.camera.cy = 185.2157;
  rig.baseline_m = 0.537;
  rig.body_from_camera = SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {1.0, -0.0, 1.5});
  return rig;
}

inline NewMap MapNamed(const std::string& name) { return {name, 1700000000000000000, StereoRig(), true}; }

inline NewSession SessionOf(MapId map, const std::string& name) {
  return {map, name, "vehicle-7", 1700000000000000001, StereoRig()};
}

// A keyframe with `keypoints` distinguishable keypoints.
inline KeyFrameRecord KeyFrameWith(uint64_t id, size_t keypoints, const Eigen::Vector3d& center = {0, 0, 0}) {
  auto features = std::make_shared<FrameFeatures>();
  for (size_t i = 0; i < keypoints; ++i) {
    const auto value = static_cast<float>(i);
    features->keypoints.push_back(
        AsStored({value * 1.1F, value * 0.7F, i % 3 == 0 ? -1.0F : value, i % 3 == 0 ? -1.0F : 4.2F,
                  value * 0.001F, static_cast<uint8_t>(i % 8), static_cast<uint8_t>(i % 5)}));
    features->descriptors.push_back({{i, id, ~uint64_t{0}, i * id}});
  }
  KeyFrameRecord keyframe;
  keyframe.id = KeyFrameId(id);
  keyframe.sequence = 10 * id;
  keyframe.timestamp = static_cast<TimestampNs>(1000 * id);
  keyframe.map_from_camera = SE3(Eigen::Quaterniond(0.9, 0.1, -0.2, 0.3), center);
  keyframe.features = std::move(features);
  return keyframe;
}

inline MapPointRecord PointAt(uint64_t id, const Eigen::Vector3d& position, uint8_t semantic_class = 7) {
  MapPointRecord point;
  point.id = MapPointId(id);
  point.position_in_map = position;
  point.normal = Eigen::Vector3f(0, -1, 0);
  point.min_distance = 2;
  point.max_distance = 17;
  point.descriptor.words = {id, 1, 2, 3};
  point.reference_keyframe = KeyFrameId(1);
  point.semantic_class = semantic_class;
  point.class_confidence = 0.75F;
  point.votes = {{semantic_class, 3}, {1, 1}};
  return AsStored(std::move(point));
}

// --- Comparison to the last bit

template <typename T>
bool SameBits(const T& a, const T& b) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

inline bool SamePose(const SE3& a, const SE3& b) {
  for (int i = 0; i < 3; ++i) {
    if (!SameBits(a.translation()[i], b.translation()[i])) return false;
  }
  for (int i = 0; i < 4; ++i) {
    if (!SameBits(a.rotation().coeffs()[i], b.rotation().coeffs()[i])) return false;
  }
  return true;
}

inline bool SameKeypoint(const Keypoint& a, const Keypoint& b) {
  return SameBits(a.x, b.x) && SameBits(a.y, b.y) && SameBits(a.right_x, b.right_x) &&
         SameBits(a.depth, b.depth) && SameBits(a.angle, b.angle) && a.octave == b.octave &&
         a.semantic_class == b.semantic_class;
}

inline bool SameFeatures(const FrameFeatures& a, const FrameFeatures& b) {
  if (a.keypoints.size() != b.keypoints.size() || a.descriptors != b.descriptors) return false;
  if (a.frame_index != b.frame_index) return false;
  for (size_t i = 0; i < a.keypoints.size(); ++i) {
    if (!SameKeypoint(a.keypoints[i], b.keypoints[i])) return false;
  }
  return true;
}

inline bool SameVotes(const std::vector<ClassVote>& a, const std::vector<ClassVote>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ClassVote& x, const ClassVote& y) {
    return x.semantic_class == y.semantic_class && x.count == y.count;
  });
}

// Positions by value: the database does not keep the sign of zero.
inline bool SamePoint(const MapPointRecord& a, const MapPointRecord& b) {
  return a.id == b.id && a.position_in_map == b.position_in_map && a.normal == b.normal &&
         a.min_distance == b.min_distance && a.max_distance == b.max_distance &&
         a.descriptor == b.descriptor && a.reference_keyframe == b.reference_keyframe &&
         a.observation_count == b.observation_count && a.first_seen == b.first_seen &&
         a.last_seen == b.last_seen && a.semantic_class == b.semantic_class &&
         a.class_confidence == b.class_confidence && SameVotes(a.votes, b.votes);
}

// --- Collecting what the store streams

inline std::vector<MapPointRecord> AllPoints(MapStore& store, MapId map, const MapPointQuery& query = {}) {
  std::vector<MapPointRecord> points;
  const absl::Status status = store.ForEachMapPoint(map, query, [&](const MapPointRecord& point) {
    points.push_back(point);
    return true;
  });
  EXPECT_TRUE(status.ok()) << status;
  return points;
}

inline std::vector<uint64_t> PointIds(MapStore& store, MapId map, const MapPointQuery& query = {}) {
  std::vector<uint64_t> ids;
  for (const MapPointRecord& point : AllPoints(store, map, query)) ids.push_back(point.id.value());
  return ids;
}

inline std::vector<KeyFrameEntry> AllKeyFrames(MapStore& store, MapId map, const KeyFrameQuery& query = {}) {
  std::vector<KeyFrameEntry> keyframes;
  const absl::Status status = store.ForEachKeyFrame(map, query, [&](const KeyFrameEntry& keyframe) {
    keyframes.push_back(keyframe);
    return true;
  });
  EXPECT_TRUE(status.ok()) << status;
  return keyframes;
}

inline std::vector<uint64_t> KeyFrameIds(MapStore& store, MapId map, const KeyFrameQuery& query = {}) {
  std::vector<uint64_t> ids;
  for (const KeyFrameEntry& keyframe : AllKeyFrames(store, map, query))
    ids.push_back(keyframe.record.id.value());
  return ids;
}

inline std::vector<TrajectoryPose> Trajectory(MapStore& store, MapId map, const TrajectoryQuery& query = {}) {
  std::vector<TrajectoryPose> poses;
  const absl::Status status = store.ForEachTrajectoryPose(map, query, [&](const TrajectoryPose& pose) {
    poses.push_back(pose);
    return true;
  });
  EXPECT_TRUE(status.ok()) << status;
  return poses;
}

// The findings of an integrity check as one text; empty: sound.
inline std::string Findings(MapStore& store, MapId map) {
  const absl::StatusOr<std::vector<IntegrityFinding>> findings = store.CheckIntegrity(map, 20);
  if (!findings.ok()) return findings.status().ToString();
  std::string text;
  for (const IntegrityFinding& finding : *findings) text += finding.kind + ": " + finding.message + "\n";
  return text;
}

}  // namespace semmap::storage
