#include "app/cli/message.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <mutex>

#include "base/core/message_limit.h"
#include "base/core/printable.h"

namespace kerf::cli {

std::string FormatMessage(std::string_view message) {
  std::string text;
  bool line_begins = true;
  while (!message.empty()) {
    const char c = message.front();
    if (line_begins && c != ' ' && c != '\n') text += "kerf: ";
    line_begins = c == '\n';
    const FirstCharacter first = FindFirstCharacter(message);
    text += first.is_printable || line_begins ? message.substr(0, first.bytes) : "?";
    message.remove_prefix(first.bytes);
  }
  return text;
}

namespace {

constexpr std::size_t kMaxOfAKind = 10;

std::mutex limit_mutex;
MessageLimit& Limit() {
  static MessageLimit limit(kMaxOfAKind);
  return limit;
}

/// Returns the end of the sentence that begins at `begin`: before the next line that does not begin with a space.
std::size_t FindSentenceEnd(std::string_view message, std::size_t begin) {
  std::size_t end = message.find('\n', begin);
  while (end != std::string_view::npos && end + 1 < message.size() &&
         (message[end + 1] == ' ' || message[end + 1] == '\n')) {
    end = message.find('\n', end + 1);
  }
  return std::min(end, message.size());
}

// A closed or full stderr does not end the program: the message is lost, the exit code is unchanged.
void Print(std::string_view message) {
  std::fputs((FormatMessage(message) + '\n').c_str(), stderr);
}

}  // namespace

void PrintMessage(std::string_view message) {
  const std::lock_guard lock(limit_mutex);
  std::size_t begin = 0;
  do {
    const std::size_t end = FindSentenceEnd(message, begin);
    if (const auto shown = Limit().Take(message.substr(begin, end - begin))) Print(*shown);
    begin = end + 1;
  } while (begin < message.size());
}

void PrintLeftOutMessages() {
  const std::lock_guard lock(limit_mutex);
  for (const std::string& sentence : Limit().TakeSuppressed()) Print(sentence);
}

}  // namespace kerf::cli
