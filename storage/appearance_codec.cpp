#include "storage/appearance_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace semmap::storage {
namespace {

constexpr uint8_t kFormat = 2;
constexpr uint8_t kFormatWithFloats = 1;
constexpr int16_t kNone = INT16_MIN;
constexpr float kEdge = 32767;
constexpr float kStepsPerDoubling = 1024;

using PackedNormal = std::array<int16_t, 2>;

int16_t Rounded(float value) { return static_cast<int16_t>(std::lround(std::clamp(value, -kEdge, kEdge))); }

PackedNormal PackNormal(const Eigen::Vector3f& normal) {
  const float length = normal.lpNorm<1>();
  // Infinite: the sum of three finite numbers overflowed, so that none of them tells a direction.
  if (length <= 0 || !std::isfinite(length)) return {kNone, kNone};
  const Eigen::Vector3f on_octahedron = normal / length;
  float u = on_octahedron.x(), v = on_octahedron.y();
  if (on_octahedron.z() < 0) {  // the lower half is folded out beyond the edges of the upper one
    u = std::copysign(1 - std::abs(on_octahedron.y()), on_octahedron.x());
    v = std::copysign(1 - std::abs(on_octahedron.x()), on_octahedron.y());
  }
  return {Rounded(kEdge * u), Rounded(kEdge * v)};
}

Eigen::Vector3f UnpackNormal(const PackedNormal& packed) {
  if (packed[0] == kNone || packed[1] == kNone) return Eigen::Vector3f::Zero();
  const auto u = static_cast<float>(packed[0]), v = static_cast<float>(packed[1]);
  const float z = kEdge - std::abs(u) - std::abs(v);
  if (z >= 0) return Eigen::Vector3f(u, v, z).normalized();
  return Eigen::Vector3f(std::copysign(kEdge - std::abs(v), u), std::copysign(kEdge - std::abs(u), v), z)
      .normalized();
}

int16_t PackDistance(float distance) {
  return distance > 0 ? Rounded(kStepsPerDoubling * std::log2(distance)) : kNone;
}

float UnpackDistance(int16_t packed) {
  return packed == kNone ? 0.0F : std::exp2(static_cast<float>(packed) / kStepsPerDoubling);
}

void ReadFloats(ByteReader& in, MapPointRecord* point) {
  in.GetArray(std::span<float>(point->normal.data(), 3));
  point->min_distance = in.Get<float>();
  point->max_distance = in.Get<float>();
}

void ReadPacked(ByteReader& in, MapPointRecord* point) {
  PackedNormal normal;
  in.GetArray(std::span<int16_t>(normal));
  point->normal = UnpackNormal(normal);
  point->min_distance = UnpackDistance(in.Get<int16_t>());
  point->max_distance = UnpackDistance(in.Get<int16_t>());
}

}  // namespace

void EncodeAppearance(const MapPointRecord& point, ByteWriter* out) {
  out->Clear();
  out->Put(kFormat);
  out->PutArray(std::span<const int16_t>(PackNormal(point.normal)));
  out->Put(PackDistance(point.min_distance));
  out->Put(PackDistance(point.max_distance));
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
  if (format != kFormat && format != kFormatWithFloats)
    return absl::DataLossError("stored map point is in a format that is not known");
  format == kFormat ? ReadPacked(in, point) : ReadFloats(in, point);
  in.GetArray(std::span<uint64_t>(point->descriptor.words));
  const uint64_t votes = in.GetVarint();
  if (!in.ok() || votes > kMaxClassVotes) return absl::DataLossError("stored map point cannot be decoded");
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

MapPointRecord AsStored(MapPointRecord point) {
  point.normal = UnpackNormal(PackNormal(point.normal));
  point.min_distance = UnpackDistance(PackDistance(point.min_distance));
  point.max_distance = UnpackDistance(PackDistance(point.max_distance));
  return point;
}

}  // namespace semmap::storage
