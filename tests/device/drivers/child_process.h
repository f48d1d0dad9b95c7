// A program run beside a test.
#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace kerf::test {

class ChildProcess {
 public:
  /// Throws std::runtime_error when it can't be started. Its stdout can be read line by line.
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  std::string ReadLine();
  /// Sends the signal and waits for its end.
  void End(int signal);
  /// Sends it and goes on.
  void Signal(int signal) const;

 private:
  pid_t pid_ = -1;
  int out_ = -1;
};

}  // namespace kerf::test
