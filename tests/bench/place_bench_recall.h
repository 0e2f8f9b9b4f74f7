#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/features/descriptor.h"
#include "slam/geometry/se3.h"
#include "slam/place/vocabulary.h"

namespace semmap::bench {

// What place recognition is asked to do with one recording. Every step-th frame is used. Without a split,
// every other one of these is in the database and the rest are queries; with one, frames before it are in the
// database, and those after it are queries. With a second recording, all of the first is the database, and
// the second brings the queries. Queries that are at no place of the database are left out.
struct RecordingSpec {
  std::string folder;  // images in it, or in its image_0 or rgb
  // Poses (KITTI's format), if any, are in poses_town.txt or poses.txt; those of two recordings in one map
  // frame.
  std::string query_folder;
  size_t step = 1;
  std::optional<size_t> split;  // frame number in the recording
};

// "FOLDER[,QUERY_FOLDER][@STEP[:SPLIT]]".
absl::StatusOr<RecordingSpec> ParseRecordingSpec(const std::string& text);

struct DescribedFrame {
  size_t number = 0;  // in the recording
  std::vector<Descriptor> descriptors;
  std::optional<SE3> map_from_camera;
  bool is_query = false;
};

struct Recording {
  RecordingSpec spec;
  std::string name;
  std::vector<DescribedFrame> frames;
};

absl::StatusOr<Recording> ReadRecording(const RecordingSpec& spec, int features);

// Shares of queries whose best, or one of whose five best, shows the same place: within 5 m and 30 degrees,
// or within 3 steps where there are no poses.
struct Recall {
  double at_1 = 0;
  double at_5 = 0;
};

struct RecallResult {
  std::string name;
  size_t database = 0;
  size_t queries = 0;
  Recall exact;  // ranked by how many descriptors have their exact nearest neighbour in the image
  Recall index;
  // Queries whose exact best is among the index's five best.
  double agreement = 0;
  // Of matches between a query and its exact best found by comparing all with all (nearest of each other, at
  // most 50 bits apart, clearly nearer than the second), how many the direct index keeps; and how many
  // comparisons it makes of those that comparing all with all does.
  double direct_matches = 0;
  double direct_comparisons = 0;
};

// `oracle_descriptors`: how many of each query the exact ranking looks up, evenly spread.
RecallResult MeasureRecall(const Recording& recording, const std::shared_ptr<const Vocabulary>& vocabulary,
                           size_t oracle_descriptors);

}  // namespace semmap::bench
