#include "storage/labels_codec.h"

#include <span>

namespace semmap::storage {
namespace {

constexpr uint8_t kFormat = 1;

void PutText(const std::string& text, ByteWriter* out) {
  out->PutVarint(text.size());
  out->PutArray(std::span<const char>(text));
}

std::string GetText(ByteReader* in) {
  const uint64_t size = in->GetVarint();
  // Before memory is taken for it.
  std::string text(size <= in->remaining() ? size : 0, '\0');
  in->GetArray(std::span<char>(text));
  if (text.size() != size) in->Fail();
  return text;
}

}  // namespace

Blob EncodeLabels(const std::map<std::string, std::string>& labels) {
  ByteWriter out;
  out.Put(kFormat);
  for (const auto& [key, value] : labels) {
    PutText(key, &out);
    PutText(value, &out);
  }
  return out.Take();
}

absl::StatusOr<std::map<std::string, std::string>> DecodeLabels(BlobView bytes) {
  ByteReader in(bytes);
  std::map<std::string, std::string> labels;
  bool sound = in.Get<uint8_t>() == kFormat;
  while (sound && in.ok() && in.remaining() > 0) {
    std::string key = GetText(&in);
    std::string value = GetText(&in);
    sound = labels.empty() || labels.rbegin()->first < key;
    labels.emplace_hint(labels.end(), std::move(key), std::move(value));
  }
  if (!sound || !in.AtEnd()) return absl::DataLossError("labels cannot be decoded");
  return labels;
}

}  // namespace semmap::storage
