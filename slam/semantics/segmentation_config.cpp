#include "slam/semantics/segmentation_config.h"

#include "slam/common/config_reader.h"

namespace semmap {

absl::Duration SegmentationConfig::max_wait() const {
  return max_wait_ms > 0 ? absl::Milliseconds(max_wait_ms) : absl::InfiniteDuration();
}

void SegmentationConfig::Read(ConfigReader& reader) {
  static constexpr const char* kNames[] = {"off", "every_frame", "keyframes"};
  std::string name = kNames[static_cast<int>(mode)];
  reader.Choice("mode", &name, {std::begin(kNames), std::end(kNames)});
  for (int i = 0; i < static_cast<int>(std::size(kNames)); ++i) {
    if (name == kNames[i]) mode = static_cast<SegmentationMode>(i);
  }
  reader.Text("model", &model);
  reader.Number("threads", &threads, 0, 256);
  reader.Number("max_batch", &max_batch, 1, 64);
  reader.Number("max_waiting", &max_waiting, 1, 10000);
  reader.Number("max_wait_ms", &max_wait_ms, 0.0, 60000.0);
}

}  // namespace semmap
