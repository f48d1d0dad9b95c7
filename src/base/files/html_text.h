// Text for HTML pages and SVG pictures.
#pragma once

#include <string>
#include <string_view>

namespace kerf {

inline bool IsControlCharacter(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

/// Escapes text for use between tags and in attributes in double quotes. Control characters, most of which XML does not
/// permit, become spaces.
inline std::string EscapeHtml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += IsControlCharacter(c) ? ' ' : c;
    }
  }
  return escaped;
}

}  // namespace kerf
