#pragma once

#include <string>

#include "slam/common/fwd.h"

namespace semmap::storage {

// Where the maps are and how the database is run.
struct StorageConfig {
  // Backend and place, "sqlite:///absolute/path.db" or "sqlite:relative/path.db".
  std::string uri = "sqlite:semmap.db";
  // NORMAL: what was acknowledged survives the death of the process, a power cut may take the last moments.
  // FULL: it survives a power cut as well; each delta waits for the disk.
  std::string synchronous = "normal";  // normal or full
  // How long to wait for somebody else's lock before UNAVAILABLE; 0 to 600000.
  int busy_timeout_ms = 10000;
  // Page cache of each connection, 1 to 4096.
  int cache_mb = 32;
  // Connections that read at the same time; further readers wait for busy_timeout_ms. 1 to 64.
  int max_readers = 8;
  // Keypoints stored of a keyframe, 0 to 65535: those that see a map point, however many, and others up to
  // this number. Fewer make maps smaller, and places a little harder to recognize. With 740 what is left of a
  // keyframe's features beyond whole pages of the database is under half a page, so that two share one.
  int keyframe_keypoints = 740;

  void Read(ConfigReader& reader);
};

}  // namespace semmap::storage
