// Work done in a child process, so that a library that aborts or hangs on a damaged file can't end the program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace kerf {

/// What the child process may use.
struct ChildLimits {
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // beyond what this process has at the start
  double silent_s = 120;                                // the longest time without progress
};

/// Memory of zeros that a child process started later shares: what it writes there is seen here.
class SharedMemory {
 public:
  /// Throws Error when there is not so much.
  explicit SharedMemory(std::size_t bytes);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  char* data() const { return static_cast<char*>(start_); }
  std::size_t size() const { return bytes_; }

 private:
  std::size_t bytes_;
  void* start_;
};

/// What the work says of itself.
class ChildReport {
 public:
  ChildReport(int pipe, char* name) : pipe_(pipe), name_(name) {}
  /// 0 to 1.
  void SetProgress(double part);
  /// The file that is read from here on: a message about the child's end names it.
  void SetName(std::string_view name);

  static constexpr std::size_t kNameBytes = 4096;

 private:
  int pipe_;
  char* name_;  // of kNameBytes, shared with the parent
};

/// Runs `work` in a forked child and returns the bytes that it returned. `work` can open files only for reading and
/// can't start programs or open sockets (where the system allows it: ForbidSideEffects()). `progress` is called in this
/// process with what the work reports; may be empty. Within such a child `work` runs at once, in the same child.
///
/// An Error that `work` throws is thrown here with the same message. Throws Error, beginning with `name` or the name
/// that the work has set, when the child ends by a signal, takes more than the limits, or can't be started. The child
/// is killed when this process ends. Not for the tick; the calling thread waits.
std::string RunInChild(const std::string& name, const ChildLimits& limits,
                       const std::function<std::string(ChildReport&)>& work,
                       const std::function<void(double)>& progress);

}  // namespace kerf
