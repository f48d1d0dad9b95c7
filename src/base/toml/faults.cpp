#include "base/toml/faults.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {

void Faults::Add(int line, int column, const std::string& what) {
  if (!full()) faults_.push_back({line, column, what});
}

void Faults::ThrowIfAny() const {
  if (faults_.empty()) return;
  std::vector<Fault> sorted = faults_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Fault& a, const Fault& b) {
    return a.line != b.line ? a.line < b.line : a.column < b.column;
  });
  std::string message;
  for (std::size_t i = 0; i < std::min(sorted.size(), kShown); ++i) {
    const Fault& f = sorted[i];
    message += fmt::format("{}{}:{}:{}: {}", i == 0 ? "" : "\n", file_, f.line, f.column, f.what);
  }
  if (sorted.size() > kShown) {
    message += fmt::format("\n{}: and {}{} more faults", file_, full() ? "at least " : "", sorted.size() - kShown);
  }
  throw Error(message);
}

}  // namespace kerf
