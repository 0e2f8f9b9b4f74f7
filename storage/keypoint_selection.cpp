#include "storage/keypoint_selection.h"

#include <algorithm>
#include <numeric>

#include "storage/checksum.h"

namespace semmap::storage {
namespace {

enum class Form : uint8_t { kBits = 1, kGaps = 2 };

constexpr size_t kHeaderSize = sizeof(uint8_t) + sizeof(uint64_t);

absl::Status Undecodable() { return absl::DataLossError("the stored list of keypoints cannot be decoded"); }

void PutBits(size_t count, std::span<const uint32_t> indices, ByteWriter* out) {
  Blob bits((count + 7) / 8, 0);
  for (const uint32_t i : indices) bits[i / 8] = static_cast<uint8_t>(bits[i / 8] | (1U << (i % 8)));
  out->PutArray(std::span<const uint8_t>(bits));
}

void PutGaps(std::span<const uint32_t> indices, ByteWriter* out) {
  out->PutVarint(indices.size());
  uint32_t next = 0;
  for (const uint32_t i : indices) {
    out->PutVarint(i - next);
    next = i + 1;
  }
}

bool GetBits(ByteReader* in, size_t count, std::vector<uint32_t>* indices) {
  Blob bits((count + 7) / 8);
  in->GetArray(std::span<uint8_t>(bits));
  for (uint32_t i = 0; i < bits.size() * 8; ++i) {
    if (((bits[i / 8] >> (i % 8)) & 1) == 0) continue;
    if (i >= count) return false;
    indices->push_back(i);
  }
  return in->AtEnd();
}

bool GetGaps(ByteReader* in, size_t count, std::vector<uint32_t>* indices) {
  const uint64_t size = in->GetVarint();
  if (size > count) return false;
  uint64_t next = 0;
  for (uint64_t i = 0; i < size; ++i) {
    const uint64_t gap = in->GetVarint();
    if (gap >= count - next) return false;
    indices->push_back(static_cast<uint32_t>(next + gap));
    next += gap + 1;
  }
  return in->AtEnd();
}

}  // namespace

std::vector<uint32_t> SelectKeypoints(size_t count, std::span<const MapPointId> point_of_keypoint,
                                      size_t at_most) {
  std::vector<uint32_t> kept(count);
  std::iota(kept.begin(), kept.end(), 0U);
  if (count <= at_most) return kept;
  const auto sees_point = [&](uint32_t i) {
    return i < point_of_keypoint.size() && point_of_keypoint[i].IsValid();
  };
  const auto others_begin = std::stable_partition(kept.begin(), kept.end(), sees_point);
  const std::vector<uint32_t> others(others_begin, kept.end());
  kept.erase(others_begin, kept.end());
  const size_t room = at_most > kept.size() ? at_most - kept.size() : 0;
  for (size_t i = 0; i < room; ++i) kept.push_back(others[i * others.size() / room]);
  std::sort(kept.begin(), kept.end());
  return kept;
}

Blob EncodeIndexSet(size_t count, std::span<const uint32_t> indices) {
  if (indices.size() == count) return {};
  ByteWriter body;
  body.PutVarint(count);
  // A gap takes one byte nearly always.
  const Form form = indices.size() < count / 8 ? Form::kGaps : Form::kBits;
  if (form == Form::kGaps) {
    PutGaps(indices, &body);
  } else {
    PutBits(count, indices, &body);
  }
  ByteWriter out;
  out.Put(static_cast<uint8_t>(form));
  out.Put(Checksum(body.view()));
  out.PutArray(body.view());
  return out.Take();
}

absl::StatusOr<std::vector<uint32_t>> DecodeIndexSet(BlobView bytes, size_t count) {
  std::vector<uint32_t> indices;
  if (bytes.empty()) {
    indices.resize(count);
    std::iota(indices.begin(), indices.end(), 0U);
    return indices;
  }
  ByteReader in(bytes);
  const auto form = static_cast<Form>(in.Get<uint8_t>());
  const auto checksum = in.Get<uint64_t>();
  if (!in.ok() || checksum != Checksum(bytes.subspan(kHeaderSize)) || in.GetVarint() != count) {
    return Undecodable();
  }
  const bool ok = form == Form::kBits   ? GetBits(&in, count, &indices)
                  : form == Form::kGaps ? GetGaps(&in, count, &indices)
                                        : false;
  if (!ok) return Undecodable();
  return indices;
}

}  // namespace semmap::storage
