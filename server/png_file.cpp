#include "server/png_file.h"

#include <array>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
constexpr size_t kHeaderLength = 13;
// Length, type and checksum around a chunk's data.
constexpr size_t kChunkOverhead = 12;

// CRC-32 as in ISO 3309, reflected.
constexpr std::array<uint32_t, 256> MakeCrcTable() {
  std::array<uint32_t, 256> table{};
  for (uint32_t byte = 0; byte < 256; ++byte) {
    uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? 0xEDB88320U ^ (crc >> 1U) : crc >> 1U;
    table[byte] = crc;
  }
  return table;
}
constexpr std::array<uint32_t, 256> kCrcTable = MakeCrcTable();

uint32_t Crc(std::string_view bytes) {
  uint32_t crc = 0xFFFFFFFFU;
  for (const char byte : bytes) crc = kCrcTable[(crc ^ static_cast<uint8_t>(byte)) & 0xFFU] ^ (crc >> 8U);
  return ~crc;
}

uint32_t BigEndian(std::string_view four_bytes) {
  uint32_t value = 0;
  for (const char byte : four_bytes.substr(0, 4)) value = (value << 8U) | static_cast<uint8_t>(byte);
  return value;
}

absl::Status Damaged(const char* what) {
  return absl::DataLossError(absl::StrCat("the PNG file is damaged: ", what));
}

struct Chunk {
  std::string_view type;
  std::string_view data;
};

// Takes the next chunk off the front of `rest`.
absl::StatusOr<Chunk> TakeChunk(std::string_view* rest) {
  if (rest->size() < kChunkOverhead) return Damaged("it ends early");
  const size_t length = BigEndian(*rest);
  if (length > rest->size() - kChunkOverhead) return Damaged("it ends early");
  const std::string_view checked = rest->substr(4, 4 + length);
  if (Crc(checked) != BigEndian(rest->substr(8 + length))) return Damaged("a checksum does not match");
  rest->remove_prefix(kChunkOverhead + length);
  return Chunk{checked.substr(0, 4), checked.substr(4)};
}

absl::StatusOr<PngHeader> ParseHeader(const Chunk& chunk) {
  if (chunk.type != "IHDR" || chunk.data.size() != kHeaderLength) return Damaged("it has no header");
  PngHeader header;
  header.width = BigEndian(chunk.data);
  header.height = BigEndian(chunk.data.substr(4));
  header.bit_depth = static_cast<uint8_t>(chunk.data[8]);
  header.grey = chunk.data[9] == 0;
  return header;
}

}  // namespace

absl::StatusOr<PngHeader> CheckPngFile(std::string_view file) {
  if (!file.starts_with(kSignature)) return Damaged("it does not begin like one");
  std::string_view rest = file.substr(kSignature.size());
  SEMMAP_ASSIGN_OR_RETURN(Chunk chunk, TakeChunk(&rest));
  SEMMAP_ASSIGN_OR_RETURN(const PngHeader header, ParseHeader(chunk));
  while (chunk.type != "IEND") {
    SEMMAP_ASSIGN_OR_RETURN(chunk, TakeChunk(&rest));
  }
  return header;
}

}  // namespace semmap::server
