#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace semmap::storage {

// Packed values are little-endian, as is every machine this runs on; they are copied, never cast in place.
static_assert(std::endian::native == std::endian::little);

using Blob = std::vector<uint8_t>;
using BlobView = std::span<const uint8_t>;

// Appends packed values to a buffer.
class ByteWriter {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    PutBytes(&value, sizeof(T));
  }
  template <typename T>
  void PutArray(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    PutBytes(values.data(), values.size_bytes());
  }
  // Seven bits a byte, lowest first; the high bit says that more follow (LEB128).
  void PutVarint(uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<uint8_t>(value | 0x80));
    bytes_.push_back(static_cast<uint8_t>(value));
  }
  // Small differences of either sign take few bytes (zigzag).
  void PutSignedVarint(int64_t value) {
    PutVarint((static_cast<uint64_t>(value) << 1) ^ static_cast<uint64_t>(value >> 63));
  }

  void Reserve(size_t size) { bytes_.reserve(size); }
  // Empties the buffer and keeps its memory.
  void Clear() { bytes_.clear(); }
  BlobView view() const { return bytes_; }
  Blob Take() { return std::move(bytes_); }

 private:
  void PutBytes(const void* data, size_t size);

  Blob bytes_;
};

// Takes packed values from bytes that may be anything: reading past the end yields zeros and makes ok() false
// for good, so that a decoder checks once, at its end.
class ByteReader {
 public:
  explicit ByteReader(BlobView bytes) : bytes_(bytes) {}

  template <typename T>
  T Get() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    GetBytes(&value, sizeof(T));
    return value;
  }
  template <typename T>
  void GetArray(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    GetBytes(values.data(), values.size_bytes());
  }
  uint64_t GetVarint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = Get<uint8_t>();
      value |= static_cast<uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80) return value;
    }
    ok_ = false;
    return 0;
  }
  int64_t GetSignedVarint() {
    const uint64_t value = GetVarint();
    return static_cast<int64_t>((value >> 1) ^ (~(value & 1) + 1));
  }

  size_t remaining() const { return bytes_.size(); }
  // What was read makes no sense.
  void Fail() { ok_ = false; }
  bool ok() const { return ok_; }
  // Everything was read and nothing was missing.
  bool AtEnd() const { return ok_ && bytes_.empty(); }

 private:
  void GetBytes(void* data, size_t size) {
    if (size == 0) return;
    if (!ok_ || size > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
      return;
    }
    std::memcpy(data, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }

  BlobView bytes_;
  bool ok_ = true;
};

}  // namespace semmap::storage
