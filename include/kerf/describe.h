// Descriptions of parameters. Each struct of parameters describes them once, in a function next to it: name with unit,
// range and meaning; the default is the member's initial value. The checks of the library, the scene reader, the
// output of `kerf scene --defaults`, the options of the command line and the documentation are derived from these
// descriptions.
//
//   template <typename V>
//   void Describe(DiscSaw& p, V&& visit) {
//     visit("diameter_mm", p.diameter_mm, Range{1, 200}, "diameter of the disc over the teeth");
//     ...
//   }
//
// A visitor has an overload for each form: visit(key, number, Range, meaning), also for vectors and optional numbers;
// visit(key, string, Choices or TextLimit, meaning); and visit(key, value, meaning) for a bool or a rotation.
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Closed range of valid values, in the unit given by the key name. For a vector: of each component.
struct Range {
  double lower;
  double upper;
  bool or_zero = false;  // 0 is valid too; it switches something off or selects a default

  constexpr bool Contains(double value) const { return (value >= lower && value <= upper) || (or_zero && value == 0); }
  constexpr double Clamp(double value) const { return value < lower ? lower : value > upper ? upper : value; }
};
/// The same range in a unit that is 1 / `factor` times as large.
constexpr Range operator*(double factor, Range range) {
  return {factor * range.lower, factor * range.upper, range.or_zero};
}
inline constexpr bool kOrZero = true;

/// Valid values of a text parameter.
struct Choices {
  std::vector<std::string_view> words;
};
/// Text on one line, at most this many characters long.
struct TextLimit {
  std::size_t characters;
};

/// World coordinates; larger ones indicate a wrong unit.
inline constexpr Range kCoordinateRange_mm{-kWorldReach_mm, kWorldReach_mm};
/// Components of a direction, which may have any length but 0.
inline constexpr Range kDirectionRange{-1000, 1000};
inline constexpr Range kPoissonRatioRange{0, 0.5};

/// Returns the unit at the end of a key name in the usual notation: "mm", "mm/s", "GPa"; empty if there is none.
std::string_view UnitOfKey(std::string_view key);
/// Returns a range as text, such as "0.02 to 10 mm". `unit` may be empty.
std::string ShowRange(Range range, std::string_view unit);
/// Returns what is wrong with a value, such as "is below 0.02; valid range 0.02 to 10 mm"; empty if it is in the range.
std::string FindRangeFault(double value, Range range, std::string_view unit);
/// Throws kerf::Error "thickness_mm = 0.01 is below 0.02; valid range 0.02 to 10 mm" if the value is not in the range.
/// `whose` (optional) precedes the key: "slice: thickness_mm = ...".
void CheckRange(std::string_view key, double value, Range range, std::string_view whose = {});

/// Visitor for Describe() that throws kerf::Error for a number out of range and for an unknown word.
class ParameterChecker {
 public:
  /// `whose` is as in CheckRange().
  explicit ParameterChecker(std::string_view whose = {}) : whose_(whose) {}

  template <typename Number>
  void operator()(const char* key, Number& value, Range range, const char*) const {
    CheckRange(key, static_cast<double>(value), range, whose_);
  }
  template <typename Number>
  void operator()(const char* key, std::optional<Number>& value, Range range, const char*) const {
    if (value) CheckRange(key, static_cast<double>(*value), range, whose_);
  }
  template <typename Number>
  void operator()(const char* key, std::vector<Number>& values, Range range, const char*) const {
    for (const Number value : values) CheckRange(key, static_cast<double>(value), range, whose_);
  }
  void operator()(const char* key, Vec3& value, Range range, const char*) const;
  void operator()(const char* key, std::string& value, const Choices& choices, const char*) const;
  void operator()(const char*, std::string&, TextLimit, const char*) const {}
  template <typename Other>
  void operator()(const char*, Other&, const char*) const {}

 private:
  std::string_view whose_;
};

/// Throws kerf::Error naming the first described parameter that is not valid. `whose` is as in CheckRange().
template <typename Params>
void CheckParameters(Params params, std::string_view whose = {}) {
  Describe(params, ParameterChecker(whose));
}

/// Visitor for Describe() that finds the range of one key.
class RangeFinder {
 public:
  explicit RangeFinder(std::string_view key) : key_(key) {}
  template <typename Value>
  void operator()(const char* key, Value&, Range range, const char*) {
    if (key == key_) range_ = range;
  }
  template <typename... Rest>
  void operator()(const char*, Rest&&...) {}
  /// Throws kerf::Error if the key was not visited.
  Range Get() const;

 private:
  std::string_view key_;
  std::optional<Range> range_;
};

/// Returns the range of a described parameter.
template <typename Params>
Range FindRange(std::string_view key) {
  Params params;
  RangeFinder finder(key);
  Describe(params, finder);
  return finder.Get();
}

}  // namespace kerf
