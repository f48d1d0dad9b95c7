// Collects the faults of a file, so that all of them are reported together.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace kerf {

class Faults {
 public:
  /// `file` is the name in messages.
  explicit Faults(std::string file) : file_(std::move(file)) {}

  void Add(int line, int column, const std::string& what);
  bool empty() const { return faults_.empty(); }
  /// Returns true when no further faults are kept, so that the caller can stop checking.
  bool full() const { return faults_.size() >= kKept; }
  /// Throws kerf::Error with a line for each fault in the order of the file, at most `kShown` of them. Returns if there
  /// are no faults.
  void ThrowIfAny() const;

  static constexpr std::size_t kShown = 50;

 private:
  static constexpr std::size_t kKept = 1000;

  struct Fault {
    int line;
    int column;
    std::string what;
  };
  std::string file_;
  std::vector<Fault> faults_;
};

}  // namespace kerf
