// Described parameters (kerf/describe.h) as keyword arguments.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdio>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.h"
#include "kerf/describe.h"
#include "kerf/error.h"

namespace kerf::python {

/// Returns "; did you mean 'teeth'?", or else the list of the known names.
std::string SuggestName(const std::string& name, const std::vector<std::string>& known);

/// Visitor that takes the values of described parameters out of keyword arguments.
class ParameterSetter {
 public:
  /// `rest` keeps the arguments that no parameter has taken.
  explicit ParameterSetter(py::dict& rest) : rest_(rest) {}

  template <typename Number>
  void operator()(const char* key, Number& value, Range, const char*) {
    known_.emplace_back(key);
    if (const py::object given = Take(key)) value = ToNumber<Number>(given, key);
  }
  template <typename Number>
  void operator()(const char* key, std::optional<Number>& value, Range, const char*) {
    known_.emplace_back(key);
    if (const py::object given = Take(key); given && !given.is_none()) value = ToNumber<Number>(given, key);
  }
  void operator()(const char* key, Vec3& value, Range, const char*) {
    known_.emplace_back(key);
    if (const py::object given = Take(key)) value = ToVec3(given, key);
  }
  void operator()(const char* key, std::string& value, const Choices&, const char*) { SetText(key, value); }
  void operator()(const char* key, std::string& value, TextLimit, const char*) { SetText(key, value); }
  void operator()(const char* key, bool& value, const char*) {
    known_.emplace_back(key);
    const py::object given = Take(key);
    if (!given) return;
    if (!py::isinstance<py::bool_>(given)) throw Error(std::string(key) + " must be True or False");
    value = py::cast<bool>(given);
  }
  void operator()(const char* key, Quat& value, const char*);

  /// Adds a name for CheckRest(), of a parameter that the caller takes.
  void AddKnown(const char* key) { known_.emplace_back(key); }
  /// Throws kerf::Error if an argument is left: "Disc has no parameter 'teth'; did you mean 'teeth'?"
  void CheckRest(const char* whose) const;

 private:
  /// Returns a null object if the argument was not given.
  py::object Take(const char* key);
  void SetText(const char* key, std::string& value);
  template <typename Number>
  static Number ToNumber(const py::object& given, const char* key) {
    try {
      if (!py::isinstance<py::bool_>(given)) return py::cast<Number>(given);
    } catch (const py::cast_error&) {
      // Reported below.
    }
    throw Error(std::string(key) +
                (std::is_integral_v<Number> ? " must be a whole number, not " : " must be a number, not ") +
                py::cast<std::string>(py::repr(given)));
  }

  py::dict& rest_;
  std::vector<std::string> known_;
};

/// Visitor that puts the values of described parameters into a dict.
class ParameterGetter {
 public:
  template <typename Value, typename... Rest>
  void operator()(const char* key, const Value& value, const Rest&...) {
    if constexpr (std::is_same_v<Value, Vec3>) {
      values_[key] = FromVec3(value);
    } else if constexpr (std::is_same_v<Value, Quat>) {
      values_[key] = py::make_tuple(value.w, value.x, value.y, value.z);
    } else {
      values_[key] = value;
    }
  }
  const py::dict& values() const { return values_; }

 private:
  py::dict values_;
};

/// Visitor that describes parameters for a docstring.
class ParameterLister {
 public:
  template <typename Number>
  void operator()(const char* key, Number& value, Range range, const char* meaning) {
    Add(key, ShowDefault(value), meaning, ShowRange(range, UnitOfKey(key)));
  }
  void operator()(const char* key, std::string& value, const Choices& choices, const char* meaning) {
    std::string words;
    for (const std::string_view word : choices.words) words += (words.empty() ? "'" : ", '") + std::string(word) + "'";
    Add(key, "'" + value + "'", meaning, words);
  }
  void operator()(const char* key, std::string& value, TextLimit, const char* meaning) {
    Add(key, "'" + value + "'", meaning, "");
  }
  void operator()(const char* key, bool& value, const char* meaning) {
    Add(key, value ? "True" : "False", meaning, "");
  }
  void operator()(const char* key, Quat&, const char* meaning) { Add(key, "(1, 0, 0, 0)", meaning, ""); }
  const std::string& text() const { return text_; }

 private:
  static std::string ShowDefault(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
  }
  static std::string ShowDefault(const Vec3& v) {
    return "(" + ShowDefault(v.x) + ", " + ShowDefault(v.y) + ", " + ShowDefault(v.z) + ")";
  }
  template <typename Number>
  static std::string ShowDefault(const std::optional<Number>& value) {
    return value ? ShowDefault(static_cast<double>(*value)) : "None";
  }
  void Add(const std::string& key, const std::string& value, const std::string& meaning, const std::string& range);

  std::string text_;
};

/// Returns the parameters of a struct as the lines of a docstring.
template <typename Params>
std::string ListParameters() {
  Params params;
  ParameterLister lister;
  Describe(params, lister);
  return lister.text();
}

/// Sets the parameters that keyword arguments name, and checks all. Throws kerf::Error.
template <typename Params>
Params ReadParameters(const py::kwargs& arguments, const char* whose, Params params = {}) {
  py::dict rest(arguments);
  ParameterSetter setter(rest);
  Describe(params, setter);
  setter.CheckRest(whose);
  CheckParameters(params, whose);
  return params;
}

/// Makes each parameter of a struct a read-only value.
template <typename Params, typename Class>
void BindValues(Class& c) {
  Params plain;
  Describe(plain, [&c](const char* key, const auto&, const auto&... about) {
    const auto get = [key](Params params) {
      ParameterGetter reader;
      Describe(params, reader);
      return py::object(reader.values()[key]);
    };
    c.def_property_readonly(key, get, std::get<sizeof...(about) - 1>(std::tie(about...)));
  });
}

/// Pickles a struct as a dict of its parameters.
template <typename Params, typename Class>
void BindPickles(Class& c, const char* whose) {
  c.def(py::pickle(
      [](Params& params) {
        ParameterGetter visitor;
        Describe(params, visitor);
        return visitor.values();
      },
      [whose](const py::dict& values) { return ReadParameters<Params>(py::kwargs(values), whose); }));
}

}  // namespace kerf::python
