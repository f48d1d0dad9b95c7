// Words of the text formats of surfaces.
#pragma once

#include <algorithm>
#include <string_view>

namespace kerf {

/// Splits a text into words at any whitespace.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}
  /// Returns an empty word at the end.
  std::string_view Next() {
    constexpr std::string_view kBlank = " \t\r\n\v\f";
    const std::size_t begin = std::min(rest_.find_first_not_of(kBlank), rest_.size());
    const std::size_t end = std::min(rest_.find_first_of(kBlank, begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }
  void SkipLine() { rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size())); }

 private:
  std::string_view rest_;
};

}  // namespace kerf
