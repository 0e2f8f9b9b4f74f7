#include "storage/feature_codec.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace semmap::storage {
namespace {

constexpr uint8_t kFormat = 1;

enum class Encoding : uint8_t { kConstant = 0, kRaw = 1, kSparse = 2 };

// Values are compared as bits: -0 and 0 are not the same, and no value is unequal to itself.
uint32_t BitsOf(float value) { return std::bit_cast<uint32_t>(value); }
uint8_t BitsOf(uint8_t value) { return value; }

// One field of all keypoints. `frequent` is what the field says when it says nothing.
template <typename T>
struct Column {
  T Keypoint::*field;
  T frequent;
};

template <typename Visitor>
bool ForEachColumn(Visitor&& visit) {
  return visit(Column<float>{&Keypoint::x, 0}) && visit(Column<float>{&Keypoint::y, 0}) &&
         visit(Column<float>{&Keypoint::right_x, -1}) && visit(Column<float>{&Keypoint::depth, -1}) &&
         visit(Column<float>{&Keypoint::angle, 0}) && visit(Column<uint8_t>{&Keypoint::octave, 0}) &&
         visit(Column<uint8_t>{&Keypoint::semantic_class, 255});
}

template <typename T>
void PutSparse(std::span<const T> values, T frequent, ByteWriter* out) {
  out->Put(frequent);
  Blob present((values.size() + 7) / 8, 0);
  std::vector<T> others;
  others.reserve(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    if (BitsOf(values[i]) == BitsOf(frequent)) continue;
    present[i / 8] = static_cast<uint8_t>(present[i / 8] | (1U << (i % 8)));
    others.push_back(values[i]);
  }
  out->PutArray(std::span<const uint8_t>(present));
  out->PutArray(std::span<const T>(others));
}

template <typename T>
void PutColumn(std::span<const T> values, T frequent, ByteWriter* out) {
  const auto equals = [](T other) { return [other](T value) { return BitsOf(value) == BitsOf(other); }; };
  if (std::all_of(values.begin(), values.end(), equals(values.front()))) {
    out->Put(static_cast<uint8_t>(Encoding::kConstant));
    out->Put(values.front());
    return;
  }
  const auto absent = static_cast<size_t>(std::count_if(values.begin(), values.end(), equals(frequent)));
  const bool sparse_is_shorter = absent * sizeof(T) > (values.size() + 7) / 8 + sizeof(T);
  out->Put(static_cast<uint8_t>(sparse_is_shorter ? Encoding::kSparse : Encoding::kRaw));
  if (sparse_is_shorter) {
    PutSparse(values, frequent, out);
  } else {
    out->PutArray(values);
  }
}

template <typename T>
bool GetSparse(ByteReader* in, std::span<T> values) {
  const T frequent = in->Get<T>();
  Blob present((values.size() + 7) / 8);
  in->GetArray(std::span<uint8_t>(present));
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = (present[i / 8] >> (i % 8)) & 1 ? in->Get<T>() : frequent;
  }
  return in->ok();
}

template <typename T>
bool GetColumn(ByteReader* in, std::span<T> values) {
  switch (static_cast<Encoding>(in->Get<uint8_t>())) {
    case Encoding::kConstant:
      std::fill(values.begin(), values.end(), in->Get<T>());
      return in->ok();
    case Encoding::kRaw:
      in->GetArray(values);
      return in->ok();
    case Encoding::kSparse:
      return GetSparse(in, values);
  }
  return false;
}

absl::Status Undecodable(const char* why) {
  return absl::DataLossError(absl::StrCat("stored features cannot be decoded: ", why));
}

}  // namespace

void EncodeFeatures(const FrameFeatures& features, ByteWriter* out) {
  const size_t count = features.keypoints.size();
  out->Clear();
  out->Reserve(5 + count * (sizeof(Keypoint) + sizeof(Descriptor)));
  out->Put(kFormat);
  out->Put(static_cast<uint32_t>(count));
  if (count == 0) return;
  ForEachColumn([&]<typename T>(Column<T> column) {
    std::vector<T> values(count);
    for (size_t i = 0; i < count; ++i) values[i] = features.keypoints[i].*column.field;
    PutColumn(std::span<const T>(values), column.frequent, out);
    return true;
  });
  out->PutArray(std::span<const Descriptor>(features.descriptors));
}

absl::StatusOr<FrameFeatures> DecodeFeatures(BlobView bytes) {
  ByteReader in(bytes);
  const auto format = in.Get<uint8_t>();
  const auto count = in.Get<uint32_t>();
  if (!in.ok() || format != kFormat) return Undecodable("unknown format");
  if (count > kMaxKeypoints || in.remaining() < count * sizeof(Descriptor))
    return Undecodable("impossible count");
  FrameFeatures features;
  if (count > 0) {
    features.keypoints.resize(count);
    features.descriptors.resize(count);
    const bool columns_ok = ForEachColumn([&]<typename T>(Column<T> column) {
      std::vector<T> values(count);
      if (!GetColumn(&in, std::span<T>(values))) return false;
      for (size_t i = 0; i < count; ++i) features.keypoints[i].*column.field = values[i];
      return true;
    });
    if (!columns_ok) return Undecodable("a column is cut short");
    in.GetArray(std::span<Descriptor>(features.descriptors));
  }
  if (!in.AtEnd()) return Undecodable("wrong length");
  return features;
}

}  // namespace semmap::storage
