// Recognises numbers and tables that a program wrote in the format of a language with a decimal comma.
#pragma once

#include <string>
#include <string_view>

namespace kerf {

/// Returns what to add to a message about text of a file that should be one number: what is wrong and the way out if it
/// has a decimal comma ("1,5") or semicolons ("1.5;2"); otherwise "".
std::string DescribeForeignNumber(std::string_view text);

/// Returns what to add to a message about a line of a table with unknown or too many columns: what is wrong and the way
/// out if its columns are separated by semicolons or tabs, or if it seems to have decimal commas; otherwise "".
std::string DescribeForeignTable(std::string_view line);

}  // namespace kerf
