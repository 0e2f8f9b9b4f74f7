#pragma once

#include <gtest/gtest.h>

#include "slam/map/map.h"
#include "slam/map/map_delta.h"
#include "slam/map/map_restorer.h"

namespace semmap::testing {

// How far the ids of the second of two maps side by side are moved.
constexpr uint64_t kSecondKeyFrames = 1000;
constexpr uint64_t kSecondPoints = 1'000'000;

// Adds a map whose changes are all of it, with its ids moved.
inline void AddMap(const MapDelta& all, const ImageBounds& bounds, uint64_t keyframes, uint64_t points,
                   MapRestorer* restorer) {
  for (MapPointRecord point : all.upserted_points) {
    point.id = MapPointId(point.id.value() + points);
    point.reference_keyframe = KeyFrameId(point.reference_keyframe.value() + keyframes);
    ASSERT_TRUE(restorer->AddPoint(point).ok());
  }
  for (size_t i = 0; i < all.added_keyframes.size(); ++i) {
    KeyFrameRecord keyframe = all.added_keyframes[i];
    std::vector<MapPointId> seen = all.observations[i].point_of_keypoint;
    ASSERT_EQ(all.observations[i].id, keyframe.id);
    for (MapPointId& point : seen) {
      if (point.IsValid()) point = MapPointId(point.value() + points);
    }
    keyframe.id = KeyFrameId(keyframe.id.value() + keyframes);
    if (keyframe.parent.IsValid()) keyframe.parent = KeyFrameId(keyframe.parent.value() + keyframes);
    ASSERT_TRUE(restorer->AddKeyFrame(keyframe, bounds, std::move(seen)).ok());
  }
}

// Two new maps in one, as storage::LoadJoinedMaps loads two: the second's ids are moved.
inline Map SideBySide(const ScalePyramidInfo& scale_info, const ImageBounds& bounds, Map first, Map second) {
  MapRestorer restorer(scale_info, MapPointId(kSecondPoints));
  AddMap(first.TakeDelta(), bounds, 0, 0, &restorer);
  AddMap(second.TakeDelta(), bounds, kSecondKeyFrames, kSecondPoints, &restorer);
  return std::move(restorer).Finish().value();
}

}  // namespace semmap::testing
