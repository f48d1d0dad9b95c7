// Text of files, for terminals.
#pragma once

#include <string>

namespace kerf {

/// `text` with '?' in place of what a terminal takes for a command: control characters (U+0000 to U+001F, U+007F to
/// U+009F), characters that change the direction of writing (U+202A to U+202E, U+2066 to U+2069), and bytes that can't
/// begin a character of UTF-8.
std::string Printable(std::string text);

}  // namespace kerf
