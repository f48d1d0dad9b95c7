// Faults of a file, gathered so that all of them are told at once.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace kerf {

class Faults {
 public:
  /// `file` names the file in messages.
  explicit Faults(std::string file) : file_(std::move(file)) {}

  void Add(int line, int column, const std::string& what);
  bool empty() const { return faults_.empty(); }
  /// So many that no more are kept: time to stop looking.
  bool full() const { return faults_.size() >= kKept; }
  /// Throws Error with a line for each fault in the order of the file, at most `kShown` of them; returns when there are
  /// none.
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
