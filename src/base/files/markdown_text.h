// External text (names, titles, messages that quote files) in a Markdown document.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "base/files/html_text.h"

namespace kerf {

/// Escapes `text` for one line of Markdown, including table cells: HTML, links and code are shown literally, and
/// control characters become spaces. Words and numbers stay unchanged.
inline std::string EscapeMarkdown(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view("\\`[]|").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c == '"' ? "\"" : EscapeHtml({&c, 1});
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
  std::replace_if(line.begin(), line.end(), IsControlCharacter, ' ');
  return line;
}

}  // namespace kerf
