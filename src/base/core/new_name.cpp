#include "base/core/new_name.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {

void CheckNewName(std::string_view what, std::string_view name, const std::function<bool(std::string_view)>& is_taken) {
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto is_allowed = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || !is_letter(name.front()) || !std::ranges::all_of(name, is_allowed)) {
    throw Error(
        fmt::format("\"{}\" cannot be the name of a new {}: it must consist of lower-case letters, digits and "
                    "\"_\", and begin with a letter",
                    name, what));
  }
  if (is_taken(name)) throw Error(fmt::format("there is already a {} named \"{}\"", what, name));
}

}  // namespace kerf
