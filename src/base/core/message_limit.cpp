#include "base/core/message_limit.h"

#include <fmt/format.h>

namespace kerf {
namespace {

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Replaces each number with one '#': digits with decimal points, including an exponent and a leading minus sign.
std::string WithoutNumbers(std::string_view text) {
  std::string kind;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!IsDigit(text[i])) {
      kind += text[i];
      continue;
    }
    if (kind.ends_with('-')) kind.pop_back();
    while (i + 1 < text.size()) {
      const char next = text[i + 1];
      const bool point = next == '.' && i + 2 < text.size() && IsDigit(text[i + 2]);
      const bool exponent = next == 'e' && i + 2 < text.size() && (IsDigit(text[i + 2]) || text[i + 2] == '-');
      if (!IsDigit(next) && !point && !exponent) break;
      i += exponent && text[i + 2] == '-' ? 2 : 1;
    }
    kind += '#';
  }
  return kind;
}

}  // namespace

std::optional<std::string> MessageLimit::Take(std::string_view message) {
  const auto [place, is_new] = index_.try_emplace(WithoutNumbers(message), kinds_.size());
  if (is_new) kinds_.push_back({std::string(message), 0});
  const std::size_t count = ++kinds_[place->second].count;
  if (count <= limit_) return std::string(message);
  if (count == limit_ + 1) return fmt::format("{} (further messages of this kind are only counted)", message);
  return {};
}

std::vector<std::string> MessageLimit::TakeSuppressed() {
  std::vector<std::string> sentences;
  for (const Kind& kind : kinds_) {
    if (kind.count <= limit_ + 1) continue;  // no message was left out: the note showed the last one
    sentences.push_back(
        fmt::format("{} more messages like this one were not shown: {}", kind.count - limit_ - 1, kind.first));
  }
  kinds_.clear();
  index_.clear();
  return sentences;
}

}  // namespace kerf
