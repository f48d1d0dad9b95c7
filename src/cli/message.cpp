#include "cli/message.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <mutex>

#include "core/message_limit.h"

namespace kerf::cli {

namespace {

/// The bytes of the character that `text` begins with when it is valid UTF-8 and no control character, else 0.
std::size_t CountPrintableBytes(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7f ? 0 : 1;
  // C0 and C1 would begin a longer form of ASCII, F5 and above are beyond U+10FFFF.
  if (first < 0xc2 || first > 0xf4) return 0;
  const std::size_t count = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (text.size() < count) return 0;
  for (std::size_t i = 1; i < count; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const unsigned char second = byte(1);
  const bool is_c1_control = first == 0xc2 && second < 0xa0;
  const bool is_overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool is_surrogate = first == 0xed && second >= 0xa0;
  const bool is_too_large = first == 0xf4 && second >= 0x90;
  return is_c1_control || is_overlong || is_surrogate || is_too_large ? 0 : count;
}

}  // namespace

std::string FormatMessage(std::string_view message) {
  std::string text;
  bool line_begins = true;
  for (std::size_t at = 0; at < message.size();) {
    const char c = message[at];
    if (line_begins && c != ' ' && c != '\n') text += "kerf: ";
    line_begins = c == '\n';
    const std::size_t count = line_begins ? 1 : CountPrintableBytes(message.substr(at));
    if (count == 0) {
      text += '?';
    } else {
      text += message.substr(at, count);
    }
    at += std::max<std::size_t>(count, 1);
  }
  return text;
}

namespace {

constexpr std::size_t kMostOfAKind = 10;

std::mutex limit_mutex;
MessageLimit& Limit() {
  static MessageLimit limit(kMostOfAKind);
  return limit;
}

/// Where the sentence that begins at `begin` ends: before the next line that does not begin with a space.
std::size_t FindSentenceEnd(std::string_view message, std::size_t begin) {
  std::size_t end = message.find('\n', begin);
  while (end != std::string_view::npos && end + 1 < message.size() &&
         (message[end + 1] == ' ' || message[end + 1] == '\n')) {
    end = message.find('\n', end + 1);
  }
  return std::min(end, message.size());
}

// A closed or full stderr is no reason to end: what it should have shown is lost, the exit code stays.
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
  for (const std::string& sentence : Limit().TakeLeftOut()) Print(sentence);
}

}  // namespace kerf::cli
