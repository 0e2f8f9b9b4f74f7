#include "storage/feature_codec_v1.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "storage/feature_codec.h"

namespace semmap::storage {
namespace {

enum class Encoding : uint8_t { kConstant = 0, kRaw = 1, kSparse = 2 };

// One field of all keypoints.
template <typename T>
struct Column {
  T Keypoint::*field;
};

template <typename Visitor>
bool ForEachColumn(Visitor&& visit) {
  return visit(Column<float>{&Keypoint::x}) && visit(Column<float>{&Keypoint::y}) &&
         visit(Column<float>{&Keypoint::right_x}) && visit(Column<float>{&Keypoint::depth}) &&
         visit(Column<float>{&Keypoint::angle}) && visit(Column<uint8_t>{&Keypoint::octave}) &&
         visit(Column<uint8_t>{&Keypoint::semantic_class});
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

absl::StatusOr<FrameFeatures> DecodeFeaturesV1(BlobView bytes) {
  ByteReader in(bytes);
  const auto format = in.Get<uint8_t>();
  const auto count = in.Get<uint32_t>();
  if (!in.ok() || format != kFeatureFormatV1) return Undecodable("unknown format");
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
