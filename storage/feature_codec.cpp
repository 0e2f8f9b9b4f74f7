#include "storage/feature_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "absl/strings/str_cat.h"
#include "storage/checksum.h"
#include "storage/feature_codec_v1.h"

namespace semmap::storage {
namespace {

constexpr uint8_t kFormat = 2;
constexpr size_t kHeaderSize = sizeof(uint8_t) + sizeof(uint64_t);

enum class Encoding : uint8_t { kConstant = 0, kDense = 1, kSparse = 2 };

// --- Keypoints as integers

constexpr float kStepsPerPixel = 32;
constexpr float kPixelLimit = 1 << 24;
constexpr double kStepsPerNeper = 2048;
// Stands for a depth of 1, and 0 for none.
constexpr int32_t kDepthOfOne = 1 << 15;
constexpr int32_t kGreatestDepth = (1 << 16) - 1;
constexpr double kStepsPerRadian = 128 / std::numbers::pi;
constexpr int32_t kStepsPerTurn = 256;

int32_t PixelSteps(float pixel) {
  return static_cast<int32_t>(std::lround(std::clamp(pixel, -kPixelLimit, kPixelLimit) * kStepsPerPixel));
}

float PixelOf(int32_t steps) { return static_cast<float>(steps) / kStepsPerPixel; }

int32_t DepthSteps(float depth) {
  if (!(depth > 0)) return 0;
  const auto steps = static_cast<int32_t>(std::lround(std::log(static_cast<double>(depth)) * kStepsPerNeper));
  return std::clamp(steps + kDepthOfOne, 1, kGreatestDepth);
}

float DepthOf(int32_t steps) {
  return steps == 0 ? -1.0F : static_cast<float>(std::exp((steps - kDepthOfOne) / kStepsPerNeper));
}

int32_t AngleSteps(float angle) {
  const auto steps =
      static_cast<int32_t>(std::lround(std::fmod(angle, 2 * std::numbers::pi) * kStepsPerRadian));
  return (steps + kStepsPerTurn) % kStepsPerTurn;
}

float AngleOf(int32_t steps) { return static_cast<float>(steps / kStepsPerRadian); }

// The columns in their order in the blob.
constexpr size_t kColumns = 7;
using PackedKeypoint = std::array<int32_t, kColumns>;

// What a column says where there is nothing to say.
constexpr PackedKeypoint kFrequent = {0, 0, -static_cast<int32_t>(kStepsPerPixel), 0, 0, 0, 255};

PackedKeypoint Pack(const Keypoint& keypoint) {
  return {PixelSteps(keypoint.x),
          PixelSteps(keypoint.y),
          keypoint.right_x < 0 ? kFrequent[2] : PixelSteps(keypoint.right_x),
          DepthSteps(keypoint.depth),
          AngleSteps(keypoint.angle),
          keypoint.octave,
          keypoint.semantic_class};
}

Keypoint Unpack(const PackedKeypoint& packed) {
  Keypoint keypoint;
  keypoint.x = PixelOf(packed[0]);
  keypoint.y = PixelOf(packed[1]);
  keypoint.right_x = PixelOf(packed[2]);
  keypoint.depth = DepthOf(packed[3]);
  keypoint.angle = AngleOf(packed[4]);
  keypoint.octave = static_cast<uint8_t>(packed[5]);
  keypoint.semantic_class = static_cast<uint8_t>(packed[6]);
  return keypoint;
}

// --- Columns of integers

uint8_t WidthOf(uint32_t greatest) {
  uint8_t width = 1;
  while (width < 4 && greatest >> (8 * width) != 0) ++width;
  return width;
}

// base, width and the values above base.
void PutIntegers(std::span<const int32_t> values, ByteWriter* out) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  const uint8_t width = WidthOf(static_cast<uint32_t>(*greatest) - static_cast<uint32_t>(*least));
  out->PutSignedVarint(*least);
  out->Put(width);
  for (const int32_t value : values) {
    const uint32_t above = static_cast<uint32_t>(value) - static_cast<uint32_t>(*least);
    for (uint8_t byte = 0; byte < width; ++byte) out->Put(static_cast<uint8_t>(above >> (8 * byte)));
  }
}

bool GetIntegers(ByteReader* in, std::span<int32_t> values) {
  const auto base = static_cast<uint32_t>(in->GetSignedVarint());
  const auto width = in->Get<uint8_t>();
  if (!in->ok() || width < 1 || width > 4 || in->remaining() < values.size() * width) return false;
  for (int32_t& value : values) {
    uint32_t above = 0;
    for (uint8_t byte = 0; byte < width; ++byte) above |= uint32_t{in->Get<uint8_t>()} << (8 * byte);
    value = static_cast<int32_t>(base + above);
  }
  return in->ok();
}

void PutSparse(std::span<const int32_t> values, int32_t frequent, ByteWriter* out) {
  Blob present((values.size() + 7) / 8, 0);
  std::vector<int32_t> others;
  for (size_t i = 0; i < values.size(); ++i) {
    if (values[i] == frequent) continue;
    present[i / 8] = static_cast<uint8_t>(present[i / 8] | (1U << (i % 8)));
    others.push_back(values[i]);
  }
  out->PutSignedVarint(frequent);
  out->PutArray(std::span<const uint8_t>(present));
  PutIntegers(others, out);
}

bool GetSparse(ByteReader* in, std::span<int32_t> values) {
  const auto frequent = static_cast<int32_t>(in->GetSignedVarint());
  Blob present((values.size() + 7) / 8);
  in->GetArray(std::span<uint8_t>(present));
  const auto is_present = [&](size_t i) { return ((present[i / 8] >> (i % 8)) & 1) != 0; };
  size_t count = 0;
  for (size_t i = 0; i < values.size(); ++i) count += is_present(i) ? 1 : 0;
  std::vector<int32_t> others(count);
  if (!GetIntegers(in, others)) return false;
  size_t next = 0;
  for (size_t i = 0; i < values.size(); ++i) values[i] = is_present(i) ? others[next++] : frequent;
  return true;
}

void PutColumn(std::span<const int32_t> values, int32_t frequent, ByteWriter* out) {
  const auto absent = static_cast<size_t>(std::count(values.begin(), values.end(), frequent));
  if (std::count(values.begin(), values.end(), values.front()) == std::ssize(values)) {
    out->Put(static_cast<uint8_t>(Encoding::kConstant));
    out->PutSignedVarint(values.front());
  } else if (absent * sizeof(uint16_t) > values.size() / 8) {
    out->Put(static_cast<uint8_t>(Encoding::kSparse));
    PutSparse(values, frequent, out);
  } else {
    out->Put(static_cast<uint8_t>(Encoding::kDense));
    PutIntegers(values, out);
  }
}

bool GetColumn(ByteReader* in, std::span<int32_t> values) {
  switch (static_cast<Encoding>(in->Get<uint8_t>())) {
    case Encoding::kConstant:
      std::fill(values.begin(), values.end(), static_cast<int32_t>(in->GetSignedVarint()));
      return in->ok();
    case Encoding::kDense:
      return GetIntegers(in, values);
    case Encoding::kSparse:
      return GetSparse(in, values);
  }
  return false;
}

// --- The whole

absl::Status Undecodable(const char* why) {
  return absl::DataLossError(absl::StrCat("stored features cannot be decoded: ", why));
}

void PutKeypoints(const FrameFeatures& features, std::span<const uint32_t> indices, ByteWriter* out) {
  std::array<std::vector<int32_t>, kColumns> columns;
  for (auto& column : columns) column.reserve(indices.size());
  for (const uint32_t i : indices) {
    const PackedKeypoint packed = Pack(features.keypoints[i]);
    for (size_t column = 0; column < kColumns; ++column) columns[column].push_back(packed[column]);
  }
  for (size_t column = 0; column < kColumns; ++column) PutColumn(columns[column], kFrequent[column], out);
}

bool GetKeypoints(ByteReader* in, std::vector<Keypoint>* keypoints) {
  std::vector<PackedKeypoint> packed(keypoints->size());
  std::vector<int32_t> values(keypoints->size());
  for (size_t column = 0; column < kColumns; ++column) {
    if (!GetColumn(in, values)) return false;
    for (size_t i = 0; i < values.size(); ++i) packed[i][column] = values[i];
  }
  std::transform(packed.begin(), packed.end(), keypoints->begin(), Unpack);
  return true;
}

}  // namespace

Keypoint AsStored(const Keypoint& keypoint) { return Unpack(Pack(keypoint)); }

void EncodeFeatures(const FrameFeatures& features, std::span<const uint32_t> indices, ByteWriter* out) {
  ByteWriter body;
  body.Reserve(16 + indices.size() * (12 + sizeof(Descriptor)));
  body.PutVarint(indices.size());
  if (!indices.empty()) {
    PutKeypoints(features, indices, &body);
    for (const uint32_t i : indices) body.PutArray(std::span<const uint64_t>(features.descriptors[i].words));
  }
  out->Clear();
  out->Reserve(kHeaderSize + body.view().size());
  out->Put(kFormat);
  out->Put(Checksum(body.view()));
  out->PutArray(body.view());
}

absl::StatusOr<FrameFeatures> DecodeFeatures(BlobView bytes) {
  if (!bytes.empty() && bytes.front() == kFeatureFormatV1) return DecodeFeaturesV1(bytes);
  ByteReader in(bytes);
  const auto format = in.Get<uint8_t>();
  const auto checksum = in.Get<uint64_t>();
  if (!in.ok() || format != kFormat) return Undecodable("unknown format");
  if (checksum != Checksum(bytes.subspan(kHeaderSize))) return Undecodable("wrong checksum");
  const uint64_t count = in.GetVarint();
  if (count > kMaxKeypoints || in.remaining() < count * sizeof(Descriptor))
    return Undecodable("impossible count");
  FrameFeatures features;
  if (count > 0) {
    features.keypoints.resize(count);
    features.descriptors.resize(count);
    if (!GetKeypoints(&in, &features.keypoints)) return Undecodable("a column is cut short");
    in.GetArray(std::span<Descriptor>(features.descriptors));
  }
  if (!in.AtEnd()) return Undecodable("wrong length");
  return features;
}

}  // namespace semmap::storage
