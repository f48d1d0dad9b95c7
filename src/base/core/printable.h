// Text of files, for terminals.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kerf {

/// The character that a text begins with.
struct FirstCharacter {
  std::size_t bytes = 1;  // 1 where it is no UTF-8
  /// UTF-8, no control character (U+0000 to U+001F, U+007F to U+009F) and none that changes the direction of writing
  /// (U+202A to U+202E, U+2066 to U+2069).
  bool is_printable = false;
};
/// `text` is not empty.
FirstCharacter FindFirstCharacter(std::string_view text);

/// `text` with '?' in place of each character that is not printable: what a terminal could take for a command.
std::string Printable(std::string_view text);

}  // namespace kerf
