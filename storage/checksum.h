#pragma once

#include "storage/byte_buffer.h"

namespace semmap::storage {

// XXH3 (64 bit, seed 0) of the bytes: tells bytes that a disk or a program changed from what was written.
uint64_t Checksum(BlobView bytes);

}  // namespace semmap::storage
