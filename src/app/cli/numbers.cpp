#include "app/cli/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "kerf/error.h"

namespace kerf::cli {

std::optional<double> ParseNumber(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
  while (!rest.empty() && rest.back() == ' ') rest.remove_suffix(1);
  if (rest.size() > 1 && rest[0] == '+' && rest[1] != '-') rest.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  // A value too small for a double is also out of range.
  if (error != std::errc() || end != rest.data() + rest.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<double> ParseNumbers(const std::string& text, char separator, std::size_t count, const char* option,
                                 const char* form) {
  std::vector<double> numbers;
  std::size_t from = 0;
  while (from <= text.size()) {
    const std::size_t to = std::min(text.find(separator, from), text.size());
    const auto value = ParseNumber(text.substr(from, to - from));
    if (!value) break;
    numbers.push_back(*value);
    from = to + 1;
  }
  if (from != text.size() + 1 || numbers.size() != count) {
    throw CLI::ValidationError(option, fmt::format("'{}' must be {}", text, form));
  }
  return numbers;
}

Vec3 ParsePoint(const std::string& text, const char* option) {
  const auto v = ParseNumbers(text, ',', 3, option, "a point x,y,z in mm, such as 24,30,0");
  const Vec3 p(v[0], v[1], v[2]);
  if (!IsInWorld(p)) {
    throw CLI::ValidationError(option, fmt::format("'{}' lies outside the world; coordinates go from {} to {} mm", text,
                                                   -kWorldReach_mm, kWorldReach_mm));
  }
  return p;
}

CLI::Validator NumberWithin(Range range, std::string_view unit) {
  const auto check = [=](const std::string& text) {
    const auto value = ParseNumber(text);
    if (!value) return fmt::format("'{}' is not a number; valid range {}", text, ShowRange(range, unit));
    const std::string fault = FindRangeFault(*value, range, unit);
    return fault.empty() ? fault : fmt::format("{} {}", text, fault);
  };
  return {check, ""};
}

CLI::Option* AddIsoOption(CLI::App& command, double& iso_hu, bool& automatic, Range range) {
  const auto take = [&iso_hu, &automatic](const std::string& text) {
    automatic = text == "auto";
    if (!automatic) iso_hu = *ParseNumber(text);
  };
  const auto check = [range](const std::string& text) {
    return text == "auto" ? std::string() : NumberWithin(range, "HU")(const_cast<std::string&>(text));
  };
  return command
      .add_option_function<std::string>(
          "--iso", take,
          fmt::format(
              "CT number of the bone's surface, {}, in the file's own values, or auto: from the histogram of the "
              "CT, for values that are not HU; default: {:g}",
              ShowRange(range, "HU"), iso_hu))
      ->check(CLI::Validator(check, ""));
}

CLI::Validator WholeNumber() {
  const auto transform = [](std::string& text) -> std::string {
    const auto value = ParseNumber(text);
    if (!value || std::abs(*value) > 1e15) return {};  // reported by NumberWithin()
    if (*value != std::round(*value)) return fmt::format("'{}' is not a whole number", text);
    text = fmt::format("{}", static_cast<std::int64_t>(*value));
    return {};
  };
  return {transform, ""};
}

std::string MakeNumberHelp(const char* key, Range range, std::string_view meaning) {
  const std::string_view unit = UnitOfKey(key);
  const std::size_t rest = std::min(meaning.find(';'), meaning.size());
  std::string help = fmt::format("{}{}{}, {}{}", meaning.substr(0, rest), unit.empty() ? "" : ", ", unit,
                                 ShowRange(range, ""), meaning.substr(rest));
  help[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(help[0])));
  return help;
}

CLI::Option* NumberOptionMaker::Get() const {
  if (made_ == nullptr) throw Error(fmt::format("there is no parameter {}", key_));
  return made_;
}

}  // namespace kerf::cli
