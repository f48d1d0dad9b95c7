// Limits repeated messages: of messages that differ only in their numbers, only the first few are shown.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace kerf {

class MessageLimit {
 public:
  explicit MessageLimit(std::size_t limit) : limit_(limit) {}

  /// Returns the text to show: the message, a note that further messages of its kind are only counted, or nothing.
  std::optional<std::string> Take(std::string_view message);
  /// Returns a sentence for each kind with messages that were not shown, in the order in which the kinds first
  /// occurred. Resets all counts.
  std::vector<std::string> TakeSuppressed();

 private:
  struct Kind {
    std::string first;  // first message of this kind
    std::size_t count = 0;
  };

  std::size_t limit_;
  std::vector<Kind> kinds_;
  std::unordered_map<std::string, std::size_t> index_;  // key: the message without its numbers
};

}  // namespace kerf
