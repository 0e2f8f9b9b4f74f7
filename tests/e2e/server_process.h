#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

extern char** environ;

namespace semmap {

// A semmapd of one's own, on any free port, with its database in `data`. Its log goes to `data`/semmapd.log.
// Killed when the object goes.
class ServerProcess {
 public:
  ServerProcess(const std::string& config, const std::string& data) {
    int fds[2];
    if (pipe2(fds, O_CLOEXEC) != 0) return;
    const std::string log = data + "/semmapd.log";
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fds[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                     0644);
    std::vector<std::string> arguments = {SEMMAPD_PATH, "--config", config,       "--data",
                                          data,         "--listen", "127.0.0.1:0"};
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    if (posix_spawn(&pid_, SEMMAPD_PATH, &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
    close(fds[1]);
    address_ = ReadAddress(fds[0]);
    close(fds[0]);
  }
  ~ServerProcess() {
    if (pid_ > 0) Stop(SIGKILL);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  // HOST:PORT; empty when it did not start.
  const std::string& address() const { return address_; }

  // Sends the signal and waits for the end; the exit code, or nothing when it died of a signal.
  std::optional<int> Stop(int signal) {
    kill(pid_, signal);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    if (!WIFEXITED(status)) return std::nullopt;
    return WEXITSTATUS(status);
  }

 private:
  // The first line must be "listening on HOST:PORT".
  static std::string ReadAddress(int fd) {
    static constexpr char kStart[] = "listening on ";
    std::string line;
    char c = 0;
    while (read(fd, &c, 1) == 1 && c != '\n') line.push_back(c);
    return line.starts_with(kStart) ? line.substr(sizeof(kStart) - 1) : "";
  }

  pid_t pid_ = -1;
  std::string address_;
};

}  // namespace semmap
