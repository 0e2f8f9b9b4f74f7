#include "storage/byte_buffer.h"

namespace semmap::storage {

// Not inline: GCC 12 unrolls several appends in a row into warnings about overflows that cannot happen.
void ByteWriter::PutBytes(const void* data, size_t size) {
  if (size == 0) return;
  const size_t offset = bytes_.size();
  bytes_.resize(offset + size);
  std::memcpy(bytes_.data() + offset, data, size);
}

}  // namespace semmap::storage
