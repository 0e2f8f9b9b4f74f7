#include "server/server_config.h"

#include "slam/common/config_reader.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

void ServerConfig::Read(ConfigReader& reader) {
  reader.Text("listen", &listen);
  reader.Number("tracking_threads", &tracking_threads, 0, 256);
  reader.Number("mapping_threads", &mapping_threads, 0, 256);
  reader.Number("query_threads", &query_threads, 1, 256);
  reader.Number("max_queries", &max_queries, 1, 100'000);
  reader.Number("max_sessions", &max_sessions, 1, 100'000);
  reader.Number("max_streams_per_connection", &max_streams_per_connection, 1, 10'000);
  reader.Number("max_message_mb", &max_message_mb, 1, 1024);
  reader.Number("max_image_pixels", &max_image_pixels, int64_t{256}, int64_t{268'435'456});
  reader.Number("credit_window", &credit_window, 1, 1024);
  reader.Number("mapper_backlog", &mapper_backlog, 0, 100);
  reader.Number("writer_queue", &writer_queue, 1, 100'000);
  reader.Number("resume_timeout_s", &resume_timeout_s, 0, 86'400);
  reader.Number("hello_timeout_s", &hello_timeout_s, 0.01, 3600);
  reader.Number("drain_timeout_s", &drain_timeout_s, 0.1, 3600);
  reader.Number("keepalive_s", &keepalive_s, 1, 7200);
  reader.Number("query_chunk", &query_chunk, 1, 20'000);
  reader.Number("map_memory_mb", &map_memory_mb, 1, 1'000'000);
  reader.Number("map_reload_s", &map_reload_s, 0, 3600);
  reader.Number("watcher_backlog", &watcher_backlog, 1, 100'000'000);
  reader.Text("artifact_directory", &artifact_directory);
  reader.Number("max_artifacts_mb", &max_artifacts_mb, 1, 10'000'000);
  reader.Number("artifact_lifetime_s", &artifact_lifetime_s, 1, 604'800);
  reader.Flag("reflection", &reflection);
  reader.Choice("log_level", &log_level, {"trace", "debug", "info", "warn", "error"});
}

Config::Config() { slam.segmentation.mode = SegmentationMode::kKeyFrames; }

void Config::Read(ConfigReader& reader) {
  reader.Section("server", &server);
  reader.Section("storage", &storage);
  reader.Section("slam", &slam);
}

absl::StatusOr<Config> Config::FromFile(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(ConfigReader reader, ConfigReader::FromFile(path));
  Config config;
  config.Read(reader);
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return config;
}

}  // namespace semmap::server
