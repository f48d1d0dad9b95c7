// A program run as a child process of a test.
#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace kerf::test {

class ChildProcess {
 public:
  /// Starts the program; its stdout can be read line by line. Throws std::runtime_error if the program cannot be
  /// started.
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  std::string ReadLine();
  /// Sends the signal and waits for the program to end.
  void End(int signal);
  /// Sends the signal and returns.
  void Signal(int signal) const;

 private:
  pid_t pid_ = -1;
  int out_ = -1;
};

}  // namespace kerf::test
