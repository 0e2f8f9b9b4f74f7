#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/byte_buffer.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// The stored features of keyframes. Keypoints are numbered as in the frame that the keyframe was made of; of
// those, only some are stored (keypoint_selection.h): a first part when the keyframe is added, and further
// ones with keypoints that came to see a map point later. Their words are stored along. Writers run inside
// the caller's transaction.
namespace semmap::storage::sqlite {

// How features are written. A value for the time of a transaction.
struct FeatureWriting {
  size_t max_keypoints = 0;
  const PlaceWording* wording = nullptr;  // null: no words
  ByteWriter buffer;                      // for scratch
};

// `point_of_keypoint`: what the keyframe sees already; empty when it is not told.
absl::Status InsertFeatures(Connection& connection, MapId map, const KeyFrameRecord& keyframe,
                            std::span<const MapPointId> point_of_keypoint, FeatureWriting* writing);
// Stores features.keypoints[positions[i]] as keypoint indices[i] of the frame; both ascending, none stored
// yet.
absl::Status AddFeatures(Connection& connection, MapId map, KeyFrameId keyframe,
                         const FrameFeatures& features, std::span<const uint32_t> positions,
                         std::span<const uint32_t> indices, size_t keypoint_count, FeatureWriting* writing);

// Which keypoints of the frame are stored, ascending. DATA_LOSS.
absl::StatusOr<std::vector<uint32_t>> ReadKeptKeypoints(Connection& connection, MapId map,
                                                        KeyFrameId keyframe, size_t keypoint_count);
// The stored keypoints in that order, with frame_index set when some are missing. DATA_LOSS.
absl::StatusOr<FrameFeatures> ReadFeatures(Connection& connection, MapId map, KeyFrameId keyframe,
                                           size_t keypoint_count);

}  // namespace semmap::storage::sqlite
