#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

extern char** environ;

namespace semmap {

// A semmapd of one's own with any arguments; what it logs goes to the end of a file. Killed when the object
// goes.
class DaemonProcess {
 public:
  DaemonProcess(std::vector<std::string> arguments, const std::string& log) {
    int fds[2];
    if (pipe2(fds, O_CLOEXEC) != 0) return;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fds[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                     0644);
    arguments.insert(arguments.begin(), SEMMAPD_PATH);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    if (posix_spawn(&pid_, SEMMAPD_PATH, &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
    close(fds[1]);
    output_ = fds[0];
  }
  ~DaemonProcess() {
    Stop(SIGKILL);
    if (output_ >= 0) close(output_);
  }
  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;

  // The next line of its output; empty at the end. Waits for it.
  std::string ReadLine() {
    std::string line;
    char c = 0;
    while (read(output_, &c, 1) == 1 && c != '\n') line.push_back(c);
    return line;
  }

  // Sends the signal (0: none) and waits for the end; the exit code, or nothing when it died of a signal.
  std::optional<int> Stop(int signal) {
    if (pid_ <= 0) return std::nullopt;
    kill(pid_, signal);
    int status = 0;
    waitpid(std::exchange(pid_, -1), &status, 0);
    if (!WIFEXITED(status)) return std::nullopt;
    return WEXITSTATUS(status);
  }

 private:
  pid_t pid_ = -1;
  int output_ = -1;
};

// A server on any free port, with its database in `data`. Its log goes to `data`/semmapd.log.
class ServerProcess {
 public:
  ServerProcess(const std::string& config, const std::string& data)
      : process_(Arguments(config, data), data + "/semmapd.log") {
    // The first line must be "listening on HOST:PORT".
    static constexpr char kStart[] = "listening on ";
    const std::string line = process_.ReadLine();
    if (line.starts_with(kStart)) address_ = line.substr(sizeof(kStart) - 1);
  }

  static std::vector<std::string> Arguments(const std::string& config, const std::string& data) {
    return {"--config", config, "--data", data, "--listen", "127.0.0.1:0"};
  }

  // HOST:PORT; empty when it did not start.
  const std::string& address() const { return address_; }
  std::optional<int> Stop(int signal) { return process_.Stop(signal); }

 private:
  DaemonProcess process_;
  std::string address_;
};

}  // namespace semmap
