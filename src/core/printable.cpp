#include "core/printable.h"

#include <cstddef>

namespace kerf {

std::string Printable(std::string text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0; };
  std::size_t next = 0;  // first byte behind the character that began last
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int first = byte(i);
    if (i < next && first >= 0x80 && first < 0xc0) continue;
    const bool is_control = first < 0x20 || first == 0x7f;
    const bool begins_none = (first >= 0x80 && first < 0xc2) || first > 0xf4;
    const bool is_second_set = first == 0xc2 && byte(i + 1) >= 0x80 && byte(i + 1) < 0xa0;
    const bool turns = first == 0xe2 && ((byte(i + 1) == 0x80 && byte(i + 2) >= 0xaa && byte(i + 2) <= 0xae) ||
                                         (byte(i + 1) == 0x81 && byte(i + 2) >= 0xa6 && byte(i + 2) <= 0xa9));
    if (is_control || begins_none) text[i] = '?';
    if (is_second_set) text.replace(i, 2, "?");
    if (turns) text.replace(i, 3, "?");
    const bool replaced = text[i] == '?';
    next = i + (replaced || first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4);
  }
  return text;
}

}  // namespace kerf
