// Lines and words of the text formats of surfaces.
#pragma once

#include <algorithm>
#include <string_view>

namespace kerf {

/// Removes the byte order mark that some programs write in front of a text.
inline std::string_view SkipByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

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
  /// Returns the rest of the line.
  std::string_view TakeLine() {
    const std::string_view line = rest_.substr(0, rest_.find_first_of("\r\n"));
    rest_.remove_prefix(line.size());
    return line;
  }

 private:
  std::string_view rest_;
};

/// Splits a text into lines that end in LF, CR LF or CR.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text), feed_(FindFeed()) {}
  /// Returns false at the end.
  bool Next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    if (feed_ < at_) feed_ = FindFeed();
    const std::size_t length = std::min(text_.substr(at_, feed_ - at_).find('\r'), feed_ - at_);
    line = text_.substr(at_, length);
    at_ += length + 1;
    if (at_ == feed_) ++at_;  // CR LF
    return true;
  }

 private:
  std::size_t FindFeed() const { return std::min(text_.find('\n', at_), text_.size()); }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t feed_;  // position of the first LF from at_ on, or the size
};

}  // namespace kerf
