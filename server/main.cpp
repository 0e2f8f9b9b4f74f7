// semmapd: the map service.
#include <csignal>
#include <cstdio>
#include <string>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "server/data_directory.h"
#include "server/logging.h"
#include "server/rpc/server.h"
#include "slam/pipeline/session.h"
#include "slam/place/vocabulary.h"
#include "slam/semantics/torch/torch_segmenter.h"
#include "storage/map_store.h"

namespace {

using semmap::server::Config;
using semmap::server::Server;

struct Options {
  std::string config_file;
  std::string data_directory;
  std::string listen;
  std::string backup_file;
};

// The signals that end the program, blocked in every thread: the main thread waits for them.
sigset_t BlockEndSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // A client that vanishes must not end the server.
  std::signal(SIGPIPE, SIG_IGN);
  return signals;
}

absl::StatusOr<Config> ReadConfig(const Options& options) {
  Config config;
  if (!options.config_file.empty()) {
    auto from_file = Config::FromFile(options.config_file);
    if (!from_file.ok()) return from_file.status();
    config = std::move(from_file).value();
  }
  if (!options.listen.empty()) config.server.listen = options.listen;
  if (!options.data_directory.empty()) {
    const absl::Status status = semmap::server::UseDataDirectory(options.data_directory, &config);
    if (!status.ok()) return status;
  }
  return config;
}

// Sessions share one vocabulary and one segmentation network.
semmap::server::SlamSessionFactory MakeSessionFactory(
    const std::shared_ptr<const semmap::Vocabulary>& vocabulary,
    const std::shared_ptr<semmap::SegmentationQueue>& segmentation) {
  return [vocabulary, segmentation](const semmap::SlamConfig& config, const semmap::CameraRig& rig,
                                    semmap::MapDeltaSink* sink, semmap::Executor* executor,
                                    semmap::SessionStart start) {
    return semmap::Session::Create(config, rig, sink, executor, vocabulary, segmentation, std::move(start));
  };
}

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "semmapd: %s\n", std::string(status.message()).c_str());
  return 1;
}

// May run beside a server that has the database open.
int Backup(const Options& options) {
  const auto config = ReadConfig(options);
  if (!config.ok()) return Fail(config.status());
  const auto store = semmap::storage::OpenMapStore(config->storage);
  if (!store.ok()) return Fail(store.status());
  const absl::Status status = (*store)->Backup(options.backup_file, nullptr);
  if (!status.ok()) return Fail(status);
  std::printf("all maps are in %s\n", options.backup_file.c_str());
  return 0;
}

int Run(const Options& options) {
  const sigset_t signals = BlockEndSignals();
  const auto config = ReadConfig(options);
  if (!config.ok()) return Fail(config.status());
  semmap::server::SetUpLogging(config->server.log_level);
  const auto vocabulary = semmap::LoadVocabulary(config->slam.place);
  if (!vocabulary.ok()) return Fail(vocabulary.status());
  const auto segmentation = semmap::LoadSegmentation(config->slam.segmentation);
  if (!segmentation.ok()) return Fail(segmentation.status());
  auto server =
      Server::Start(*config, MakeSessionFactory(*vocabulary, *segmentation), *vocabulary, *segmentation);
  if (!server.ok()) return Fail(server.status());
  std::printf("listening on %s\n", (*server)->address().c_str());
  std::fflush(stdout);
  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("stopping signal={}", signal);
  (*server)->Drain();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("semmap map service: vehicles stream frames and get poses, maps are kept in a database");
  app.add_option("--config", options.config_file, "YAML configuration file")->check(CLI::ExistingFile);
  app.add_option("--data", options.data_directory, "Directory of the database; created if it is not there");
  app.add_option("--listen", options.listen, "HOST:PORT; port 0 takes any");
  app.add_option("--backup", options.backup_file,
                 "Write all maps to this new file and end; also while a server is running");
  CLI11_PARSE(app, argc, argv);
  return options.backup_file.empty() ? Run(options) : Backup(options);
}
