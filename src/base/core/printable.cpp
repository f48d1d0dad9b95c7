#include "base/core/printable.h"

#include <algorithm>

namespace kerf {

FirstCharacter FindFirstCharacter(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {1, first >= 0x20 && first != 0x7f};
  // C0 and C1 would begin an overlong form of ASCII; F5 and above are beyond U+10FFFF.
  if (first < 0xc2 || first > 0xf4) return {1, false};
  const std::size_t bytes = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (text.size() < bytes) return {1, false};
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {1, false};
  }
  const unsigned char second = byte(1);
  const bool is_overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool is_surrogate = first == 0xed && second >= 0xa0;
  const bool is_too_large = first == 0xf4 && second >= 0x90;
  if (is_overlong || is_surrogate || is_too_large) return {1, false};
  const bool is_control = first == 0xc2 && second < 0xa0;
  const bool changes_direction = first == 0xe2 && ((second == 0x80 && byte(2) >= 0xaa && byte(2) <= 0xae) ||
                                                   (second == 0x81 && byte(2) >= 0xa6 && byte(2) <= 0xa9));
  return {bytes, !is_control && !changes_direction};
}

std::string Printable(std::string_view text) {
  std::string printable;
  while (!text.empty()) {
    const FirstCharacter first = FindFirstCharacter(text);
    printable += first.is_printable ? text.substr(0, first.bytes) : "?";
    text.remove_prefix(first.bytes);
  }
  return printable;
}

std::size_t CountCharacters(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string FirstCharacters(std::string_view text, std::size_t count) {
  std::size_t end = 0;
  for (std::size_t seen = 0; end < text.size(); ++end) {
    const bool begins = (static_cast<unsigned char>(text[end]) & 0xc0) != 0x80;
    if (begins && seen++ == count) break;
  }
  return std::string(text.substr(0, end));
}

}  // namespace kerf
