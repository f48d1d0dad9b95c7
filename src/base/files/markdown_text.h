// External text (names, titles, messages that quote files) in a Markdown document.
#pragma once

#include <string>
#include <string_view>

namespace kerf {

/// Escapes `text` for one line of Markdown, including table cells: HTML, links and code are shown literally, and
/// control characters become spaces. Words and numbers stay unchanged.
inline std::string EscapeMarkdown(std::string_view text) {
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
      case '\\':
      case '`':
      case '[':
      case ']':
      case '|':
        escaped += '\\';
        escaped += c;
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return escaped;
}

/// Returns `name` as a code span, or as escaped text if a code span cannot contain it.
inline std::string MarkdownCode(std::string_view name) {
  const std::string escaped = EscapeMarkdown(name);
  return escaped == name ? "`" + escaped + "`" : escaped;
}

/// Returns one line for a code block; without line breaks it cannot end the block.
inline std::string MarkdownCodeLine(std::string_view command) {
  std::string line(command);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return line;
}

}  // namespace kerf
