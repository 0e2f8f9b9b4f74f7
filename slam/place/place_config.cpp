#include "slam/place/place_config.h"

#include "slam/common/config_reader.h"

namespace semmap {

void PlaceQueryLimits::Read(ConfigReader& reader) {
  reader.Number("max_postings", &max_postings, 1000, INT64_C(1000000000));
  reader.Number("max_candidates", &max_candidates, 1, 1000000);
}

void PlaceConfig::Read(ConfigReader& reader) {
  reader.Text("vocabulary", &vocabulary);
  reader.Section("query", &query);
}

}  // namespace semmap
