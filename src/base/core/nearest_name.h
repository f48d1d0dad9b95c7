// What a misspelt name may have meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// Letters to insert, delete or replace to make `b` of `a` (Levenshtein).
std::size_t CalcEditDistance(std::string_view a, std::string_view b);

/// The one of `names` nearest to `name`, or "" when none is near: more than a third of the letters, and more than two,
/// differ. Upper and lower case count as the same letter.
std::string FindNearestName(std::string_view name, const std::vector<std::string>& names);

}  // namespace kerf
