// Names of what a program adds to kerf's lists.
#pragma once

#include <functional>
#include <string_view>

namespace kerf {

/// Throws kerf::Error if `name` is not made of lower-case letters, digits and "_", beginning with a letter, or if
/// `is_taken` returns true for it. `what`: "effect".
void CheckNewName(std::string_view what, std::string_view name, const std::function<bool(std::string_view)>& is_taken);

}  // namespace kerf
