#include "storage/words_codec.h"

#include <limits>

#include "storage/checksum.h"
#include "storage/feature_codec.h"

namespace semmap::storage {
namespace {

constexpr uint8_t kFormat = 1;
constexpr size_t kHeaderSize = sizeof(uint8_t) + sizeof(uint64_t);

absl::Status Undecodable() { return absl::DataLossError("stored words cannot be decoded"); }

}  // namespace

void EncodeWords(std::span<const uint32_t> words, ByteWriter* out) {
  ByteWriter body;
  body.Reserve(4 + 2 * words.size());
  body.PutVarint(words.size());
  uint32_t last = 0;
  for (const uint32_t word : words) {
    body.PutVarint(word - last);
    last = word;
  }
  out->Clear();
  out->Reserve(kHeaderSize + body.view().size());
  out->Put(kFormat);
  out->Put(Checksum(body.view()));
  out->PutArray(body.view());
}

absl::StatusOr<std::vector<uint32_t>> DecodeWords(BlobView bytes) {
  ByteReader in(bytes);
  const auto format = in.Get<uint8_t>();
  const auto checksum = in.Get<uint64_t>();
  if (!in.ok() || format != kFormat || checksum != Checksum(bytes.subspan(kHeaderSize))) return Undecodable();
  const uint64_t count = in.GetVarint();
  if (!in.ok() || count > kMaxKeypoints || count > in.remaining()) return Undecodable();
  std::vector<uint32_t> words;
  words.reserve(count);
  uint64_t word = 0;
  for (uint64_t i = 0; i < count; ++i) {
    word += in.GetVarint();
    if (word > std::numeric_limits<uint32_t>::max()) return Undecodable();
    words.push_back(static_cast<uint32_t>(word));
  }
  if (!in.AtEnd()) return Undecodable();
  return words;
}

}  // namespace semmap::storage
