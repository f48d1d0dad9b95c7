// Runs the program in parallel with a test, on a separate terminal if requested. The test can send keys and signals and
// can wait.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <spawn.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>

#include "support/program.h"

namespace kerf::test {

/// Limit of all waits in tests. It is sufficient for the slowest machine, so an event that takes longer counts as
/// missing.
inline constexpr std::chrono::seconds kMaxWait{60};

/// Waits until `holds` returns true. Returns false if that takes longer than `longest`.
inline bool WaitUntil(const std::function<bool()>& holds, std::chrono::milliseconds longest = kMaxWait) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

enum class At : std::uint8_t {
  kNoTerminal,  // its input is empty; output goes to stdout.txt and stderr.txt of the folder
  kKeys,        // its input is a terminal
  kTerminal,    // input and stdout are a terminal
};

class Running {
 public:
  /// `command`: a program and its arguments in shell syntax. The folder is its current folder.
  Running(std::filesystem::path folder, At at, const std::string& command) : folder_(std::move(folder)) {
    if (openpty(&master_, &terminal_, nullptr, nullptr, nullptr) != 0)
      throw std::runtime_error("a terminal could not be opened");
    for (const int end : {master_, terminal_}) fcntl(end, F_SETFD, FD_CLOEXEC);
    before_ = Settings();
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    const auto open_at = [&](int number, const std::string& path, int flags) {
      posix_spawn_file_actions_addopen(&actions, number, path.c_str(), flags, 0644);
    };
    constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC | O_APPEND;
    if (at == At::kNoTerminal) open_at(STDIN_FILENO, "/dev/null", O_RDONLY);
    if (at != At::kNoTerminal) posix_spawn_file_actions_adddup2(&actions, terminal_, STDIN_FILENO);
    if (at == At::kTerminal) posix_spawn_file_actions_adddup2(&actions, terminal_, STDOUT_FILENO);
    if (at != At::kTerminal) open_at(STDOUT_FILENO, folder_ / "stdout.txt", kWrite);
    open_at(STDERR_FILENO, folder_ / "stderr.txt", kWrite);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    std::string line = "cd '" + folder_.string() + "' && exec env -u DISPLAY " + command;
    std::string shell = "sh";
    std::string option = "-c";
    char* const words[] = {shell.data(), option.data(), line.data(), nullptr};
    const int failed = posix_spawn(&id_, "/bin/sh", &actions, &attributes, words, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw std::runtime_error("the program could not be started");
  }
  ~Running() {
    if (!Ended()) {
      kill(-id_, SIGKILL);  // and its child processes
      waitpid(id_, nullptr, 0);
    }
    close(master_);
    close(terminal_);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  void Type(const std::string& keys) const {
    if (write(master_, keys.data(), keys.size()) != static_cast<ssize_t>(keys.size())) {
      throw std::runtime_error("the keys could not be written to the terminal");
    }
  }
  void Signal(int number) const { kill(id_, number); }

  std::string out() const { return Slurp(folder_ / "stdout.txt"); }
  std::string err() const { return Slurp(folder_ / "stderr.txt"); }
  bool Said(const std::string& text) const { return err().find(text) != std::string::npos; }
  /// Returns everything sent to the terminal so far: the program's output, and echoed keys.
  const std::string& Shown() {
    for (;;) {
      pollfd output{.fd = master_, .events = POLLIN, .revents = 0};
      char bytes[4096];
      if (poll(&output, 1, 0) != 1) return shown_;
      const ssize_t got = read(master_, bytes, sizeof(bytes));
      if (got <= 0) return shown_;
      shown_.append(bytes, static_cast<std::size_t>(got));
    }
  }
  termios Settings() const {
    termios settings{};
    if (tcgetattr(terminal_, &settings) != 0) throw std::runtime_error("the terminal settings could not be read");
    return settings;
  }

  /// Terminal settings before the program started.
  const termios& SettingsBefore() const { return before_; }

  bool Ended() {
    if (!ended_ && waitpid(id_, &status_, WNOHANG) == id_) ended_ = true;
    return ended_;
  }
  /// Waits until `holds` returns true. Returns false if the program ends first.
  bool Until(const std::function<bool()>& holds) {
    bool held = false;
    WaitUntil([&] { return (held = holds()) || Ended(); });
    return held || holds();
  }
  bool UntilSaid(const std::string& text) {
    return Until([&] { return Said(text); });
  }
  /// Returns the exit code, or -1 if the program does not end.
  int WaitForEnd() {
    if (!WaitUntil([this] { return Ended(); })) return -1;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }

 private:
  std::filesystem::path folder_;
  pid_t id_ = -1;
  int master_ = -1;
  int terminal_ = -1;
  termios before_{};
  int status_ = 0;
  bool ended_ = false;
  std::string shown_;
};

inline bool AreSame(const termios& a, const termios& b) {
  return a.c_iflag == b.c_iflag && a.c_oflag == b.c_oflag && a.c_cflag == b.c_cflag && a.c_lflag == b.c_lflag &&
         std::equal(std::begin(a.c_cc), std::end(a.c_cc), std::begin(b.c_cc));
}

}  // namespace kerf::test
