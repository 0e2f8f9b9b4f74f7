#include "storage/observation_codec.h"

#include <algorithm>

#include "storage/feature_codec.h"

namespace semmap::storage {
namespace {

constexpr uint8_t kFormat = 1;

absl::Status Undecodable() { return absl::DataLossError("stored observations cannot be decoded"); }

// Calls begin(keypoints, observations) and then see(keypoint, id) for each observation; false for bytes that
// nobody wrote.
template <typename Begin, typename See>
bool Decode(BlobView bytes, const Begin& begin, const See& see) {
  ByteReader in(bytes);
  const auto format = in.Get<uint8_t>();
  const uint64_t keypoints = in.GetVarint();
  const uint64_t observations = in.GetVarint();
  if (!in.ok() || format != kFormat || keypoints > kMaxKeypoints || observations > keypoints) return false;
  begin(keypoints, observations);
  uint64_t next_keypoint = 0;
  uint64_t id = 0;
  for (uint64_t i = 0; i < observations; ++i) {
    const uint64_t gap = in.GetVarint();
    id += static_cast<uint64_t>(in.GetSignedVarint());
    if (!in.ok() || gap >= keypoints - next_keypoint || id == 0 || id >> 63 != 0) return false;
    next_keypoint += gap;
    see(next_keypoint++, MapPointId(id));
  }
  return in.AtEnd();
}

}  // namespace

uint32_t EncodeObservations(const std::vector<MapPointId>& point_of_keypoint, ByteWriter* out) {
  const auto observations = static_cast<uint32_t>(std::count_if(
      point_of_keypoint.begin(), point_of_keypoint.end(), [](MapPointId point) { return point.IsValid(); }));
  out->Clear();
  out->Put(kFormat);
  out->PutVarint(point_of_keypoint.size());
  out->PutVarint(observations);
  size_t next_keypoint = 0;
  int64_t last_id = 0;
  for (size_t i = 0; i < point_of_keypoint.size(); ++i) {
    if (!point_of_keypoint[i].IsValid()) continue;
    const auto id = static_cast<int64_t>(point_of_keypoint[i].value());
    out->PutVarint(i - next_keypoint);
    out->PutSignedVarint(id - last_id);
    next_keypoint = i + 1;
    last_id = id;
  }
  return observations;
}

absl::StatusOr<std::vector<MapPointId>> DecodeObservations(BlobView bytes) {
  std::vector<MapPointId> point_of_keypoint;
  const bool decoded = Decode(
      bytes, [&](uint64_t keypoints, uint64_t) { point_of_keypoint.resize(keypoints); },
      [&](uint64_t keypoint, MapPointId id) { point_of_keypoint[keypoint] = id; });
  if (!decoded) return Undecodable();
  return point_of_keypoint;
}

absl::StatusOr<std::vector<MapPointId>> DecodeSeenPoints(BlobView bytes) {
  std::vector<MapPointId> points;
  const bool decoded = Decode(
      bytes, [&](uint64_t, uint64_t observations) { points.reserve(observations); },
      [&](uint64_t, MapPointId id) { points.push_back(id); });
  if (!decoded) return Undecodable();
  return points;
}

}  // namespace semmap::storage
