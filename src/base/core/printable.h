// Safe display of text from files in a terminal, and its length in characters.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kerf {

/// First character of a text.
struct FirstCharacter {
  std::size_t bytes = 1;  // 1 if it is not valid UTF-8
  /// True for valid UTF-8 that is not a control character (U+0000 to U+001F, U+007F to U+009F) and does not change the
  /// writing direction (U+202A to U+202E, U+2066 to U+2069).
  bool is_printable = false;
};
/// Examines the first character of `text`, which must not be empty.
FirstCharacter FindFirstCharacter(std::string_view text);

/// Returns `text` with '?' in place of each character that is not printable, so that a terminal cannot interpret it as
/// a command.
std::string Printable(std::string_view text);

/// Returns the number of characters of UTF-8 text.
std::size_t CountCharacters(std::string_view text);

/// Returns the first characters of UTF-8 text.
std::string FirstCharacters(std::string_view text, std::size_t count);

}  // namespace kerf
