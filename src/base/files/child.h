// Runs work in a child process, so that a library that aborts or hangs on a damaged file cannot crash or block kerf.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace kerf {

/// Resource limits of the child process.
struct ChildLimits {
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // in addition to the memory of this process at the start
  double silent_s = 120;                                // maximum time without progress
};

/// Zero-initialised memory that is shared with a child process started later: this process can read what the child
/// writes.
class SharedMemory {
 public:
  /// Throws kerf::Error if there is not enough memory.
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

/// Reports from the work to the parent process.
class ChildReport {
 public:
  ChildReport(int pipe, char* name) : pipe_(pipe), name_(name) {}
  /// Reports the completed fraction, 0 to 1.
  void SetProgress(double part);
  /// Sets the name of the file that is read from now on, for messages about a failure of the child.
  void SetName(std::string_view name);

  static constexpr std::size_t kNameBytes = 4096;

 private:
  int pipe_;
  char* name_;  // kNameBytes bytes, shared with the parent
};

/// Runs `work` in a forked child and returns its result. `work` can open files only for reading and cannot start
/// programs or open sockets (if the system supports this; see ForbidSideEffects()). `progress` (optional) is called in
/// this process with the progress that `work` reports, and repeatedly with the same value while it reports none; if it
/// throws (Cancelled), the child is killed and the exception passes. If the caller is already such a child, `work` runs
/// directly in it.
///
/// Rethrows a kerf::Error from `work` with the same message. Throws kerf::Error, whose message begins with `name` or
/// the name that `work` has set, if the child is killed by a signal, exceeds the limits, or cannot be started. The
/// child is killed when this process ends. Not for the tick; the calling thread waits.
std::string RunInChild(const std::string& name, const ChildLimits& limits,
                       const std::function<std::string(ChildReport&)>& work,
                       const std::function<void(double)>& progress);

}  // namespace kerf
