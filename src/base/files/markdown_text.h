// Text from outside (names, titles, messages that quote files) in a Markdown document.
#pragma once

#include <string>
#include <string_view>

namespace kerf {

/// `text` as words of one line of Markdown, in a table cell too: HTML, links and code show as they are
/// written, control characters become spaces. Words and numbers stay as they are.
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

/// `name` as a code span; as escaped words where a code span could not hold it.
inline std::string MarkdownCode(std::string_view name) {
  const std::string escaped = EscapeMarkdown(name);
  return escaped == name ? "`" + escaped + "`" : escaped;
}

/// One line for a block of code: without line breaks it can't end the block.
inline std::string MarkdownCodeLine(std::string_view command) {
  std::string line(command);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return line;
}

}  // namespace kerf
