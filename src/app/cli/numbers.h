// Parsing of numbers on the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf::cli {

/// Parses a finite decimal number, optionally surrounded by spaces. Does not accept hexadecimal, "nan" or "inf".
std::optional<double> ParseNumber(const std::string& text);
/// Parses exactly `count` numbers between separators. Throws CLI::ValidationError: "'text' must be `form`".
std::vector<double> ParseNumbers(const std::string& text, char separator, std::size_t count, const char* option,
                                 const char* form);
/// Parses x,y,z in mm within the world's coordinates. Throws CLI::ValidationError.
Vec3 ParsePoint(const std::string& text, const char* option);
/// Returns a validator that distinguishes text that is not a number from a number that is out of range. Its message
/// states the range and the unit.
CLI::Validator NumberWithin(Range range, std::string_view unit);

/// Adds an option for the CT number of the bone's surface, or 'auto'.
CLI::Option* AddIsoOption(CLI::App& command, double& iso_hu, bool& automatic, Range range);

/// Returns a transform that writes a whole number in plain digits, because CLI11 reads 010 as octal and cannot read
/// 1e3. Refuses a number that is not whole.
CLI::Validator WholeNumber();

/// Type of an option for whole numbers, also optional or several.
template <typename Value>
concept WholeOption = std::integral<Value> || requires {
  requires std::integral<typename Value::value_type>;
};

/// Returns the help of an option from the description of its parameter, such as "Memory for undo, MB, 0.2 to 1000; the
/// oldest checkpoints are dropped first".
std::string MakeNumberHelp(const char* key, Range range, std::string_view meaning);

/// Adds an option for a number, which must be in the range. `key` is the name with the unit.
template <typename Value>
CLI::Option* AddNumberOption(CLI::App& command, const std::string& option, Value& value, const char* key, Range range,
                             std::string_view meaning) {
  CLI::Option* made = command.add_option(option, value, MakeNumberHelp(key, range, meaning));
  made->check(NumberWithin(range, UnitOfKey(key)));
  if constexpr (WholeOption<Value>) made->transform(WholeNumber());  // runs before the check
  return made;
}

/// Visitor for Describe() that adds an option for one parameter.
class NumberOptionMaker {
 public:
  /// `meaning` replaces that of the description if it is not empty.
  NumberOptionMaker(CLI::App& command, std::string option, std::string_view key, std::string_view meaning)
      : command_(command), option_(std::move(option)), key_(key), meaning_(meaning) {}

  template <typename Value>
  requires(!std::same_as<Value, Vec3>) void operator()(const char* key, Value& value, Range range,
                                                       const char* meaning) {
    if (key != key_) return;
    made_ = AddNumberOption(command_, option_, value, key, range, meaning_.empty() ? meaning : meaning_);
  }
  template <typename... Rest>
  void operator()(const char*, Rest&&...) {}
  /// Throws Error if the key was not visited.
  CLI::Option* Get() const;

 private:
  CLI::App& command_;
  std::string option_;
  std::string_view key_;
  std::string_view meaning_;
  CLI::Option* made_ = nullptr;
};

/// Adds an option for a described parameter of `params`, with its range, and its meaning unless another one is given.
template <typename Params>
CLI::Option* AddNumber(CLI::App& command, const std::string& option, Params& params, std::string_view key,
                       std::string_view meaning = {}) {
  NumberOptionMaker maker(command, option, key, meaning);
  Describe(params, maker);
  return maker.Get();
}

}  // namespace kerf::cli
