#include "base/files/json_text.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/core/printable.h"
#include "base/files/limits.h"
#include "kerf/error.h"

namespace kerf {

void CheckJsonDepth(const std::string& text, const std::string& path) {
  int depth = 0;
  bool within_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (within_text) {
      if (c == '\\') ++i;
      if (c == '"') within_text = false;
    } else if (c == '"') {
      within_text = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxJsonDepth) {
        throw Error(fmt::format("{}: lists and objects are nested more than {} deep", path, kMaxJsonDepth));
      }
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
}

nlohmann::json ParseJson(const std::string& text, const std::string& path) {
  CheckJsonDepth(text, path);
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& e) {
    const std::string what = e.what();  // begins with "[json.exception.parse_error.101] "
    throw Error(fmt::format("{}: not valid JSON ({})", path, Printable(what.substr(what.find(' ') + 1))));
  }
}

int GetInt(const nlohmann::json& value) {
  if (value.is_number()) {
    const auto number = value.get<double>();
    if (std::abs(number) <= std::numeric_limits<int>::max() && number == std::trunc(number)) {
      return static_cast<int>(number);
    }
  }
  throw Error(fmt::format("{} is not a whole number of at most {}", value.dump(), std::numeric_limits<int>::max()));
}

}  // namespace kerf
