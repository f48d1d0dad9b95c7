// Parameters of an effect, from the description of its struct of parameters (kerf/describe.h).
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "kerf/describe.h"
#include "kerf/effects.h"

namespace kerf {

template <typename T>
concept EffectNumber = std::is_arithmetic_v<T> && !std::same_as<T, bool>;

/// Visitor for Describe() that lists parameters with their defaults. In addition to the forms of kerf/describe.h it
/// takes an enumeration, visit(key, value, Choices, meaning), and the name of a file, visit(key, text, EffectFileKind,
/// meaning).
class EffectParameterLister {
 public:
  template <EffectNumber Number>
  void operator()(const char* key, Number& value, Range range, const char* meaning) {
    list_.push_back({key, static_cast<double>(value), range.lower, range.upper, meaning});
    list_.back().whole = std::integral<Number>;
  }
  void operator()(const char* key, Vec3& value, Range range, const char* meaning) {
    list_.push_back({key, value, range.lower, range.upper, meaning});
  }
  void operator()(const char* key, bool& value, const char* meaning) {
    list_.push_back({.key = key, .default_value = value, .meaning = meaning});
  }
  void operator()(const char* key, std::string& value, const Choices& choices, const char* meaning) {
    list_.push_back({.key = key, .default_value = value, .meaning = meaning, .words = choices.words});
  }
  template <typename Enum>
  requires std::is_enum_v<Enum>
  void operator()(const char* key, Enum& value, const Choices& choices, const char* meaning) {
    std::string word(choices.words[static_cast<std::size_t>(value)]);
    (*this)(key, word, choices, meaning);
  }
  void operator()(const char* key, std::string& value, EffectFileKind file, const char* meaning) {
    list_.push_back({.key = key, .default_value = value, .meaning = meaning, .file = file});
  }
  std::vector<EffectParameter> Take() { return std::move(list_); }

 private:
  std::vector<EffectParameter> list_;
};

/// Visitor for Describe() that sets parameters to the values of an EffectChoice, which are in the order of the
/// description.
class EffectValueReader {
 public:
  explicit EffectValueReader(std::span<const EffectValue> values) : values_(values) {}

  template <EffectNumber Number>
  void operator()(const char*, Number& value, Range, const char*) {
    const double number = Next<double>();
    if constexpr (std::integral<Number>) {
      value = static_cast<Number>(std::llround(number));
    } else {
      value = number;
    }
  }
  void operator()(const char*, Vec3& value, Range, const char*) { value = Next<Vec3>(); }
  void operator()(const char*, bool& value, const char*) { value = Next<bool>(); }
  template <typename Valid>
  void operator()(const char*, std::string& value, const Valid&, const char*) {
    value = Next<std::string>();
  }
  template <typename Enum>
  requires std::is_enum_v<Enum>
  void operator()(const char*, Enum& value, const Choices& choices, const char*) {
    const std::string& word = Next<std::string>();
    for (std::size_t i = 0; i < choices.words.size(); ++i) {
      if (choices.words[i] == word) value = static_cast<Enum>(i);
    }
  }

 private:
  template <typename T>
  const T& Next() {
    return std::get<T>(values_[next_++]);
  }

  std::span<const EffectValue> values_;
  std::size_t next_ = 0;
};

/// Returns EffectInfo::parameters of an effect with the parameters `Params`.
template <typename Params>
std::vector<EffectParameter> ListEffectParameters() {
  Params params;
  EffectParameterLister lister;
  Describe(params, lister);
  return lister.Take();
}
/// Returns the parameters with the values of an EffectChoice.
template <typename Params>
Params ReadEffectParameters(std::span<const EffectValue> values) {
  Params params;
  Describe(params, EffectValueReader(values));
  return params;
}

}  // namespace kerf
