#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "slam/pipeline/slam_config.h"
#include "storage/storage_config.h"

namespace semmap::server {

// The `server` section. Every bound of the service is here.
struct ServerConfig {
  std::string listen = "127.0.0.1:50051";  // HOST:PORT; port 0: any
  // 0: as many as the machine has cores.
  int tracking_threads = 0;  // frames of all sessions, one thread at a time for each session
  int mapping_threads = 0;   // mappers of all sessions, likewise
  int query_threads = 2;     // unary calls and queries
  int max_queries = 64;      // running and waiting; more: RESOURCE_EXHAUSTED
  int max_sessions = 64;     // running and interrupted; more: RESOURCE_EXHAUSTED
  int max_streams_per_connection = 128;
  int max_message_mb = 32;
  int64_t max_image_pixels = 16'777'216;
  int credit_window = 8;   // frames that a session may have on the way
  int writer_queue = 256;  // changes of maps that wait for the database; more: mappers wait
  // BLOCK sessions: keyframes that may wait for the mapper when the next frame is tracked. 0: the map is
  // always up to date, and tracking waits for it.
  int mapper_backlog = 0;
  double resume_timeout_s = 30;
  double hello_timeout_s = 10;  // for the first message of a stream
  double drain_timeout_s = 30;  // for sessions to end when the server stops
  double keepalive_s = 60;      // between pings to silent clients
  int query_chunk = 2000;       // points or poses in one message
  // Stored maps that are looked for places in, all together; more: RESOURCE_EXHAUSTED. And the shortest time
  // between two loadings of a map that changes.
  int map_memory_mb = 512;
  double map_reload_s = 1;
  int watcher_backlog = 100'000;  // changed things that wait for a watcher; more: it is too slow
  // Files of imports and exports. A relative directory lies in that of the database; nobody else may use it.
  std::string artifact_directory = "artifacts";
  int max_artifacts_mb = 4096;        // all files together; more: RESOURCE_EXHAUSTED
  double artifact_lifetime_s = 3600;  // until what an export wrote is deleted
  bool reflection = true;
  std::string log_level = "info";  // trace, debug, info, warn, error

  void Read(ConfigReader& reader);
};

// The whole file of semmapd.
struct Config {
  ServerConfig server;
  storage::StorageConfig storage;
  // The library's defaults, but for the segmentation of keyframes: a service's maps have classes.
  SlamConfig slam;

  Config();
  void Read(ConfigReader& reader);
  // INVALID_ARGUMENT lists everything wrong with file and line.
  static absl::StatusOr<Config> FromFile(const std::string& path);
};

}  // namespace semmap::server
