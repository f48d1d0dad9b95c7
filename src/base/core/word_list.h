// Lists of words in sentences.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// Returns "a", "a and b" or "a, b and c".
inline std::string JoinWords(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += i == 0 ? "" : i + 1 == words.size() ? " and " : ", ";
    text += words[i];
  }
  return text;
}

}  // namespace kerf
