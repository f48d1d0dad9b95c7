// JSON that somebody else wrote.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace kerf {

/// Throws Error with one sentence that begins with `path`, the text's name, when lists and objects stand more than
/// kMaxJsonDepth deep within each other: copying and printing what was parsed takes a frame of the stack for each.
/// Looks at brackets alone. Not for the tick.
void CheckJsonDepth(const std::string& text, const std::string& path);
/// The same, and throws Error when it is not JSON.
nlohmann::json ParseJson(const std::string& text, const std::string& path);
/// A whole number. Throws Error when `value` is none, or one that an int can't hold, whose conversion by the library
/// has no defined result.
int GetInt(const nlohmann::json& value);

}  // namespace kerf
