#include "storage/appearance_codec.h"

namespace semmap::storage {
namespace {

constexpr uint8_t kFormat = 1;

}  // namespace

void EncodeAppearance(const MapPointRecord& point, ByteWriter* out) {
  out->Clear();
  out->Put(kFormat);
  out->PutArray(std::span<const float>(point.normal.data(), 3));
  out->Put(point.min_distance);
  out->Put(point.max_distance);
  out->PutArray(std::span<const uint64_t>(point.descriptor.words));
  out->PutVarint(point.votes.size());
  for (const ClassVote& vote : point.votes) {
    out->Put(vote.semantic_class);
    out->PutVarint(vote.count);
  }
}

absl::Status DecodeAppearance(BlobView bytes, MapPointRecord* point) {
  ByteReader in(bytes);
  const auto format = in.Get<uint8_t>();
  in.GetArray(std::span<float>(point->normal.data(), 3));
  point->min_distance = in.Get<float>();
  point->max_distance = in.Get<float>();
  in.GetArray(std::span<uint64_t>(point->descriptor.words));
  const uint64_t votes = in.GetVarint();
  if (!in.ok() || format != kFormat || votes > kMaxClassVotes) {
    return absl::DataLossError("stored map point cannot be decoded");
  }
  point->votes.resize(votes);
  for (ClassVote& vote : point->votes) {
    vote.semantic_class = in.Get<uint8_t>();
    const uint64_t count = in.GetVarint();
    if (count > UINT32_MAX) return absl::DataLossError("stored class vote cannot be decoded");
    vote.count = static_cast<uint32_t>(count);
  }
  if (!in.AtEnd()) return absl::DataLossError("stored map point has a wrong length");
  return absl::OkStatus();
}

}  // namespace semmap::storage
