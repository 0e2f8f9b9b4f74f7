#include "slam/place/vocabulary_file.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap {
namespace {

// The file is memory as it stands.
static_assert(std::endian::native == std::endian::little);

constexpr std::array<char, 8> kMagic = {'S', 'E', 'M', 'M', 'A', 'P', 'V', 'C'};
constexpr uint32_t kVersion = 1;

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kVersion;
  uint32_t branching = 0;
  uint32_t levels = 0;
  uint32_t direct_level = 0;
  uint32_t training_images = 0;
  uint32_t nodes = 0;
  uint32_t words = 0;
  uint32_t reserved = 0;
  uint64_t checksum = 0;
  std::array<uint64_t, 2> reserved_too{};
};
static_assert(sizeof(Header) == 64);
static_assert(offsetof(Header, checksum) == 40);

uint64_t ChecksumOf(const char* bytes, size_t size) {
  XXH3_state_t state;
  XXH3_INITSTATE(&state);
  XXH3_64bits_reset(&state);
  constexpr size_t kAfter = offsetof(Header, checksum) + sizeof(Header::checksum);
  XXH3_64bits_update(&state, bytes, offsetof(Header, checksum));
  XXH3_64bits_update(&state, bytes + kAfter, size - kAfter);
  return XXH3_64bits_digest(&state);
}

template <typename T>
void Append(std::span<const T> values, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

// Takes `count` values off the front.
template <typename T>
std::span<const T> Take(size_t count, std::span<const std::byte>* bytes) {
  const std::span values(reinterpret_cast<const T*>(bytes->data()), count);
  *bytes = bytes->subspan(values.size_bytes());
  return values;
}

uint64_t SizeOf(const Header& header) {
  return sizeof(Header) + uint64_t{header.nodes} * (sizeof(Descriptor) + sizeof(VocabularyNode)) +
         uint64_t{header.words} * sizeof(float);
}

absl::StatusOr<Header> DecodeHeader(std::span<const std::byte> bytes) {
  Header header;
  if (bytes.size() < sizeof(header)) return absl::DataLossError("vocabulary: shorter than its header");
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != kMagic) return absl::InvalidArgumentError("not a vocabulary");
  if (header.version != kVersion) {
    return absl::InvalidArgumentError(
        absl::StrCat("vocabulary of version ", header.version, ", this program reads version ", kVersion));
  }
  if (bytes.size() != SizeOf(header)) {
    return absl::DataLossError(
        absl::StrCat("vocabulary: has ", bytes.size(), " bytes, should have ", SizeOf(header)));
  }
  if (ChecksumOf(reinterpret_cast<const char*>(bytes.data()), bytes.size()) != header.checksum) {
    return absl::DataLossError("vocabulary: damaged, its checksum is wrong");
  }
  return header;
}

}  // namespace

std::string EncodeVocabulary(const VocabularyView& vocabulary) {
  Header header;
  header.branching = vocabulary.branching;
  header.levels = vocabulary.levels;
  header.direct_level = vocabulary.direct_level;
  header.training_images = vocabulary.training_images;
  header.nodes = static_cast<uint32_t>(vocabulary.nodes.size());
  header.words = static_cast<uint32_t>(vocabulary.idf.size());
  std::string bytes;
  bytes.reserve(SizeOf(header));
  Append(std::span<const Header>(&header, 1), &bytes);
  Append(vocabulary.centres, &bytes);
  Append(vocabulary.nodes, &bytes);
  Append(vocabulary.idf, &bytes);
  const uint64_t checksum = ChecksumOf(bytes.data(), bytes.size());
  std::memcpy(bytes.data() + offsetof(Header, checksum), &checksum, sizeof(checksum));
  return bytes;
}

absl::StatusOr<VocabularyView> DecodeVocabulary(std::span<const std::byte> bytes) {
  SEMMAP_ASSIGN_OR_RETURN(const Header header, DecodeHeader(bytes));
  std::span<const std::byte> rest = bytes.subspan(sizeof(Header));
  VocabularyView vocabulary;
  vocabulary.branching = header.branching;
  vocabulary.levels = header.levels;
  vocabulary.direct_level = header.direct_level;
  vocabulary.training_images = header.training_images;
  vocabulary.centres = Take<Descriptor>(header.nodes, &rest);
  vocabulary.nodes = Take<VocabularyNode>(header.nodes, &rest);
  vocabulary.idf = Take<float>(header.words, &rest);
  SEMMAP_RETURN_IF_ERROR(CheckVocabulary(vocabulary));
  return vocabulary;
}

uint64_t DigestOf(std::span<const std::byte> bytes) {
  uint64_t digest = 0;
  std::memcpy(&digest, bytes.data() + offsetof(Header, checksum), sizeof(digest));
  return digest;
}

absl::Status WriteVocabulary(const std::string& path, const VocabularyView& vocabulary) {
  const std::string bytes = EncodeVocabulary(vocabulary);
  const std::string unfinished = absl::StrCat(path, ".part");
  std::ofstream file(unfinished, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(unfinished, path, error);
  if (!file || error) return absl::UnavailableError(absl::StrCat(path, ": cannot be written"));
  return absl::OkStatus();
}

}  // namespace semmap
