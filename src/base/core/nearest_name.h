// Suggestions for misspelt names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// Returns the number of letters to insert, delete or replace to turn `a` into `b` (Levenshtein distance).
std::size_t CalcEditDistance(std::string_view a, std::string_view b);

/// Returns the nearest of `names`, ignoring case, or "" if none is near. A name is near if its edit distance is at most
/// 2 or a third of the letters of `name`, whichever is more.
std::string FindNearestName(std::string_view name, const std::vector<std::string>& names);

}  // namespace kerf
