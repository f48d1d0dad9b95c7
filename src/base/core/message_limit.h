// Messages that differ in their numbers only are of one kind, and only the first few of each kind are shown.
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
  explicit MessageLimit(std::size_t most) : most_(most) {}

  /// What is to be shown: the message, a note that more of its kind will only be counted, or nothing.
  std::optional<std::string> Take(std::string_view message);
  /// A sentence for each kind of which more came than were shown, in the order in which the kinds first came; they are
  /// counted from 0 again.
  std::vector<std::string> TakeLeftOut();

 private:
  struct Kind {
    std::string first;  // message
    std::size_t count = 0;
  };

  std::size_t most_;
  std::vector<Kind> kinds_;
  std::unordered_map<std::string, std::size_t> index_;  // by the message without its numbers
};

}  // namespace kerf
