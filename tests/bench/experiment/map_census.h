#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slam/evaluation/trajectory_collector.h"
#include "slam/map/map_delta.h"
#include "slam/semantics/taxonomy.h"
#include "tests/bench/experiment/truth_label.h"

namespace semmap::bench {

// What the points of a map truly are. A point's truth is the label that most of the keypoints that see it
// have (of equally many the first).
struct MapCensus {
  struct Group {
    uint64_t points = 0;
    uint64_t on_traffic_vehicles = 0;
    uint64_t on_pedestrians = 0;
    uint64_t on_parked_vehicles = 0;
    uint64_t on_sky = 0;
  };
  Group all;
  Group active;
  // Active points by their true class: how many have it in the map, and the same for the single keypoints
  // that see them, which is what one frame alone says.
  struct ClassTally {
    uint64_t points = 0;
    uint64_t correct = 0;
    uint64_t labels = 0;
    uint64_t correct_labels = 0;
  };
  std::array<ClassTally, kSemanticClassCount> classes;
  // Of keyframes: all, and those on traffic.
  uint64_t keypoints = 0;
  uint64_t keypoints_on_traffic = 0;
};

// Listens to a session whose frames' true labels are known; keeps the trajectory, too. One thread.
class CensusSink : public MapDeltaSink {
 public:
  // `labels(sequence)` gives the encoded labels of a frame, which is the newest or one of the kHistory before
  // it.
  using LabelsOf = std::function<cv::Mat(uint64_t sequence)>;
  static constexpr int kHistory = 40;

  CensusSink(LabelsOf labels, const ClassSet& inactive) : labels_(std::move(labels)), inactive_(inactive) {}

  void OnDelta(MapDelta delta) override;

  MapCensus TakeCensus() const;
  const TrajectoryCollector& trajectory() const { return trajectory_; }

 private:
  struct KeyFrameLabels {
    std::vector<uint8_t> truth;
    std::vector<uint8_t> seen_as;
    std::vector<MapPointId> points;
  };
  struct Views {
    std::vector<uint8_t> truth;  // encoded, of each view
    std::vector<uint8_t> seen_as;
  };

  void AddKeyFrame(const KeyFrameRecord& keyframe);
  std::unordered_map<MapPointId, Views, IdHash> GatherViews() const;

  LabelsOf labels_;
  ClassSet inactive_;
  TrajectoryCollector trajectory_;
  std::unordered_map<MapPointId, uint8_t, IdHash> class_of_point_;
  std::unordered_map<KeyFrameId, KeyFrameLabels, IdHash> keyframes_;
};

// The value that occurs most often, of equally frequent ones the first; `values` is not empty.
uint8_t MostFrequent(const std::vector<uint8_t>& values);

}  // namespace semmap::bench
