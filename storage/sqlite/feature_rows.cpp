#include "storage/sqlite/feature_rows.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "slam/common/status_macros.h"
#include "storage/feature_codec.h"
#include "storage/keypoint_selection.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/word_rows.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kInsert[] =
    "INSERT INTO keyframe_features (map_id, keyframe_id, part, kept, features) "
    "SELECT ?1, ?2, count(*), ?3, ?4 FROM keyframe_features WHERE map_id = ?1 AND keyframe_id = ?2";
constexpr char kSelectKept[] =
    "SELECT kept FROM keyframe_features WHERE map_id = ? AND keyframe_id = ? ORDER BY part";
constexpr char kSelectParts[] =
    "SELECT kept, features FROM keyframe_features WHERE map_id = ? AND keyframe_id = ? ORDER BY part";

absl::Status InsertPart(Connection& connection, MapId map, KeyFrameId keyframe, BlobView kept,
                        BlobView features) {
  Query insert(connection, kInsert);
  return insert.Bind(map).Bind(keyframe).BindBlob(kept).BindBlob(features).Run();
}

// The keypoints at these positions.
FrameFeatures Select(const FrameFeatures& features, std::span<const uint32_t> positions) {
  FrameFeatures selected;
  selected.keypoints.reserve(positions.size());
  selected.descriptors.reserve(positions.size());
  for (const uint32_t position : positions) {
    selected.keypoints.push_back(features.keypoints[position]);
    selected.descriptors.push_back(features.descriptors[position]);
  }
  return selected;
}

absl::Status Contradiction() { return absl::DataLossError("a keypoint is stored twice"); }

// The parts of a keyframe put together, in no order yet.
struct Parts {
  std::vector<uint32_t> indices;
  FrameFeatures features;

  absl::Status Append(BlobView kept, BlobView part, size_t keypoint_count) {
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<uint32_t> held, DecodeIndexSet(kept, keypoint_count));
    SEMMAP_ASSIGN_OR_RETURN(const FrameFeatures decoded, DecodeFeatures(part));
    if (decoded.size() != held.size()) {
      return absl::DataLossError("number of keypoints contradicts the stored features");
    }
    indices.insert(indices.end(), held.begin(), held.end());
    features.keypoints.insert(features.keypoints.end(), decoded.keypoints.begin(), decoded.keypoints.end());
    features.descriptors.insert(features.descriptors.end(), decoded.descriptors.begin(),
                                decoded.descriptors.end());
    return absl::OkStatus();
  }

  absl::StatusOr<FrameFeatures> InOrder(size_t keypoint_count) && {
    if (!std::is_sorted(indices.begin(), indices.end())) Sort();
    if (std::adjacent_find(indices.begin(), indices.end()) != indices.end()) return Contradiction();
    if (indices.size() < keypoint_count) features.frame_index = std::move(indices);
    return std::move(features);
  }

 private:
  void Sort() {
    std::vector<size_t> order(indices.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(), [this](size_t a, size_t b) { return indices[a] < indices[b]; });
    Parts sorted;
    for (const size_t i : order) {
      sorted.indices.push_back(indices[i]);
      sorted.features.keypoints.push_back(features.keypoints[i]);
      sorted.features.descriptors.push_back(features.descriptors[i]);
    }
    *this = std::move(sorted);
  }
};

}  // namespace

absl::Status InsertFeatures(Connection& connection, MapId map, const KeyFrameRecord& keyframe,
                            std::span<const MapPointId> point_of_keypoint, FeatureWriting* writing) {
  const FrameFeatures& features = *keyframe.features;
  const std::vector<uint32_t> kept =
      SelectKeypoints(features.size(), point_of_keypoint, writing->max_keypoints);
  EncodeFeatures(features, kept, &writing->buffer);
  SEMMAP_RETURN_IF_ERROR(InsertPart(connection, map, keyframe.id, EncodeIndexSet(features.size(), kept),
                                    writing->buffer.view()));
  if (writing->wording == nullptr) return absl::OkStatus();
  return WriteWords(connection, map, writing->wording->vocabulary,
                    {keyframe.id, writing->wording->words_of(Select(features, kept))}, &writing->buffer);
}

absl::Status AddFeatures(Connection& connection, MapId map, KeyFrameId keyframe,
                         const FrameFeatures& features, std::span<const uint32_t> positions,
                         std::span<const uint32_t> indices, size_t keypoint_count, FeatureWriting* writing) {
  EncodeFeatures(features, positions, &writing->buffer);
  SEMMAP_RETURN_IF_ERROR(
      InsertPart(connection, map, keyframe, EncodeIndexSet(keypoint_count, indices), writing->buffer.view()));
  if (writing->wording == nullptr) return EraseWords(connection, map, keyframe);
  return AddWords(connection, map, writing->wording->vocabulary,
                  {keyframe, writing->wording->words_of(Select(features, positions))}, &writing->buffer);
}

absl::StatusOr<std::vector<uint32_t>> ReadKeptKeypoints(Connection& connection, MapId map,
                                                        KeyFrameId keyframe, size_t keypoint_count) {
  Query select(connection, kSelectKept);
  select.Bind(map).Bind(keyframe);
  std::vector<uint32_t> all;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) break;
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<uint32_t> held,
                            DecodeIndexSet(select.Bytes(0), keypoint_count));
    all.insert(all.end(), held.begin(), held.end());
  }
  std::sort(all.begin(), all.end());
  if (std::adjacent_find(all.begin(), all.end()) != all.end()) return Contradiction();
  return all;
}

absl::StatusOr<FrameFeatures> ReadFeatures(Connection& connection, MapId map, KeyFrameId keyframe,
                                           size_t keypoint_count) {
  Query select(connection, kSelectParts);
  select.Bind(map).Bind(keyframe);
  Parts parts;
  bool found = false;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (!row) break;
    found = true;
    SEMMAP_RETURN_IF_ERROR(parts.Append(select.Bytes(0), select.Bytes(1), keypoint_count));
  }
  if (!found) return absl::DataLossError("has no features");
  return std::move(parts).InOrder(keypoint_count);
}

}  // namespace semmap::storage::sqlite
