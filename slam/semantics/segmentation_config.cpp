#include "slam/semantics/segmentation_config.h"

#include <algorithm>
#include <vector>

#include "slam/common/config_reader.h"

namespace semmap {
namespace {

void ReadMode(ConfigReader& reader, const char* key, SegmentationMode* mode) {
  static const std::vector<std::string> names = {"off", "every_frame", "keyframes"};
  std::string name = names[static_cast<size_t>(*mode)];
  reader.Choice(key, &name, names);
  *mode = static_cast<SegmentationMode>(std::find(names.begin(), names.end(), name) - names.begin());
}

}  // namespace

absl::Duration SegmentationConfig::max_wait() const {
  return max_wait_ms > 0 ? absl::Milliseconds(max_wait_ms) : absl::InfiniteDuration();
}

void SegmentationConfig::Read(ConfigReader& reader) {
  ReadMode(reader, "mode", &mode);
  ReadMode(reader, "live_mode", &live_mode);
  reader.Text("model", &model);
  reader.Number("threads", &threads, 0, 256);
  reader.Number("max_batch", &max_batch, 1, 64);
  reader.Number("max_waiting", &max_waiting, 1, 10000);
  reader.Number("max_wait_ms", &max_wait_ms, 0.0, 60000.0);
}

}  // namespace semmap
