// Reading of untrusted JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace kerf {

/// Throws kerf::Error with one sentence that begins with `path`, the name of the text, if lists and objects are nested
/// more than kMaxJsonDepth deep: copying and printing parsed JSON uses a stack frame per level. Looks only at brackets.
/// Not for the tick.
void CheckJsonDepth(const std::string& text, const std::string& path);
/// Parses JSON after CheckJsonDepth(). Throws kerf::Error if it is not JSON.
nlohmann::json ParseJson(const std::string& text, const std::string& path);
/// Returns an integer. Throws kerf::Error if `value` is not an integer or exceeds the range of an int, for which the
/// library's conversion is undefined.
int GetInt(const nlohmann::json& value);

}  // namespace kerf
