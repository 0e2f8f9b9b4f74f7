#include "storage/checksum.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace semmap::storage {

uint64_t Checksum(BlobView bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

}  // namespace semmap::storage
