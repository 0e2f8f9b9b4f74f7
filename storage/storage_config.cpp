#include "storage/storage_config.h"

#include "slam/common/config_reader.h"

namespace semmap::storage {

void StorageConfig::Read(ConfigReader& reader) {
  reader.Text("uri", &uri);
  reader.Choice("synchronous", &synchronous, {"normal", "full"});
  reader.Number("busy_timeout_ms", &busy_timeout_ms, 0, 600000);
  reader.Number("cache_mb", &cache_mb, 1, 4096);
  reader.Number("max_readers", &max_readers, 1, 64);
  reader.Number("keyframe_keypoints", &keyframe_keypoints, 0, 65535);
}

}  // namespace semmap::storage
