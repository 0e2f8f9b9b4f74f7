#include "tests/bench/experiment/map_census.h"

#include <algorithm>

#include "slam/semantics/class_votes.h"

namespace semmap::bench {
namespace {

constexpr auto kVehicles = static_cast<uint8_t>(SemanticClass::kVehicles);
constexpr auto kSky = static_cast<uint8_t>(SemanticClass::kSky);

void Count(const TruthLabel& truth, MapCensus::Group* group) {
  ++group->points;
  if (truth.semantic_class == kSky) ++group->on_sky;
  if (truth.semantic_class == kVehicles) {
    ++(truth.traffic ? group->on_traffic_vehicles : group->on_parked_vehicles);
  } else if (truth.traffic) {
    ++group->on_pedestrians;
  }
}

// Whether traffic moves just now does not make a point another thing.
uint8_t WithoutMotion(uint8_t code) { return static_cast<uint8_t>(code & ~kTruthMoving); }

}  // namespace

uint8_t MostFrequent(const std::vector<uint8_t>& values) {
  std::array<int, 256> counts{};
  for (const uint8_t value : values) ++counts[value];
  return *std::max_element(values.begin(), values.end(),
                           [&](uint8_t a, uint8_t b) { return counts[a] < counts[b]; });
}

void CensusSink::AddKeyFrame(const KeyFrameRecord& keyframe) {
  const cv::Mat labels = labels_(keyframe.sequence);
  KeyFrameLabels& kept = keyframes_[keyframe.id];
  for (const Keypoint& keypoint : keyframe.features->keypoints) {
    const int x = std::clamp(static_cast<int>(keypoint.x + 0.5F), 0, labels.cols - 1);
    const int y = std::clamp(static_cast<int>(keypoint.y + 0.5F), 0, labels.rows - 1);
    kept.truth.push_back(labels.at<uint8_t>(y, x));
    kept.seen_as.push_back(keypoint.semantic_class);
  }
}

void CensusSink::OnDelta(MapDelta delta) {
  if (delta.reset) {
    class_of_point_.clear();
    keyframes_.clear();
  }
  for (const KeyFrameRecord& keyframe : delta.added_keyframes) AddKeyFrame(keyframe);
  for (const MapPointRecord& point : delta.upserted_points) class_of_point_[point.id] = point.semantic_class;
  for (const KeyFrameObservations& seen : delta.observations) {
    const auto keyframe = keyframes_.find(seen.id);
    if (keyframe != keyframes_.end()) keyframe->second.points = seen.point_of_keypoint;
  }
  for (const RemovedKeyFrame& removed : delta.removed_keyframes) keyframes_.erase(removed.removed);
  for (const MapPointId id : delta.removed_points) class_of_point_.erase(id);
  trajectory_.OnDelta(std::move(delta));
}

std::unordered_map<MapPointId, CensusSink::Views, IdHash> CensusSink::GatherViews() const {
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : keyframes_) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  std::unordered_map<MapPointId, Views, IdHash> views;
  for (const KeyFrameId id : ids) {
    const KeyFrameLabels& keyframe = keyframes_.at(id);
    for (size_t i = 0; i < keyframe.points.size(); ++i) {
      if (!keyframe.points[i].IsValid()) continue;
      Views& of_point = views[keyframe.points[i]];
      of_point.truth.push_back(WithoutMotion(keyframe.truth[i]));
      of_point.seen_as.push_back(keyframe.seen_as[i]);
    }
  }
  return views;
}

MapCensus CensusSink::TakeCensus() const {
  MapCensus census;
  for (const auto& [id, views] : GatherViews()) {
    const auto point = class_of_point_.find(id);
    if (point == class_of_point_.end()) continue;
    const TruthLabel truth = DecodeLabel(MostFrequent(views.truth));
    Count(truth, &census.all);
    if (inactive_.Contains(point->second)) continue;
    Count(truth, &census.active);
    if (truth.semantic_class >= kSemanticClassCount) continue;
    MapCensus::ClassTally& tally = census.classes[truth.semantic_class];
    ++tally.points;
    tally.correct += point->second == truth.semantic_class ? 1 : 0;
    tally.labels += views.seen_as.size();
    tally.correct_labels +=
        static_cast<uint64_t>(std::count(views.seen_as.begin(), views.seen_as.end(), truth.semantic_class));
  }
  for (const auto& [id, keyframe] : keyframes_) {
    census.keypoints += keyframe.truth.size();
    for (const uint8_t code : keyframe.truth)
      census.keypoints_on_traffic += DecodeLabel(code).traffic ? 1 : 0;
  }
  return census;
}

}  // namespace semmap::bench
