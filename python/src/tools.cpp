#include "tools.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "copies.h"
#include "cut/tool/kinds.h"
#include "kerf/error.h"
#include "parameters.h"

namespace kerf::python {
namespace {

/// Calls call(T()) for each alternative T of Tool.
template <typename Call, std::size_t... kKinds>
void ForEachKind(const Call& call, std::index_sequence<kKinds...>) {
  (call(std::variant_alternative_t<kKinds, Tool>()), ...);
}
template <typename Call>
void ForEachKind(const Call& call) {
  ForEachKind(call, std::make_index_sequence<std::variant_size_v<Tool>>());
}

/// Returns the name of the class, which is a literal.
template <IsToolKind T>
constexpr const char* NameClass() {
  return ToolKind<T>::kClass.data();
}

/// Returns the parameters as arguments in Python: "teeth=24", "grip_mm=(0.0, 0.0, 80.0)".
template <typename T>
std::vector<std::string> ShowArguments(T tool) {
  std::vector<std::string> arguments;
  Describe(tool, [&arguments]<typename Value>(const char* key, const Value& value, const auto&...) {
    py::object shown;
    if constexpr (std::is_same_v<Value, Vec3>) {
      shown = py::make_tuple(value.x, value.y, value.z);
    } else {
      shown = py::cast(value);
    }
    arguments.push_back(std::string(key) + "=" + py::cast<std::string>(py::repr(shown)));
  });
  return arguments;
}

/// Returns the call that makes the tool, with its shape and with what else is not the default.
template <IsToolKind T>
std::string ShowCall(T tool) {
  const std::vector<std::string> defaults = ShowArguments(T());
  std::vector<std::string> shape;
  DescribeShape(tool, [&shape](const char* key, const auto&...) { shape.push_back(std::string(key) + "="); });
  std::string text;
  for (const std::string& argument : ShowArguments(tool)) {
    const bool plain = std::find(defaults.begin(), defaults.end(), argument) != defaults.end();
    const bool shapes =
        std::any_of(shape.begin(), shape.end(), [&](const std::string& key) { return argument.starts_with(key); });
    if (!plain || shapes) text += (text.empty() ? "" : ", ") + argument;
  }
  return std::string("kerf.") + NameClass<T>() + "(" + text + ")";
}

template <IsToolKind T>
std::string DescribeSense() {
  if constexpr (ToolKind<T>::kDrive == DriveMotion::kRotation) {
    return ToolKind<T>::kSense < 0 ? " It turns clockwise as seen from the handpiece: rpm < 0."
                                   : " It turns counter-clockwise as seen from the handpiece: rpm > 0.";
  } else {
    return "";
  }
}

template <IsToolKind T>
void BindKind(py::module_& m) {
  const char* const name = NameClass<T>();
  const std::string text = std::string(name) + "(**parameters): " + std::string(ToolKind<T>::kSummary) +
                           ". Tool frame: " + std::string(ToolKind<T>::kFrame) + "." + DescribeSense<T>() +
                           "\n\nParameters, each by name:\n" + ListParameters<T>();
  py::class_<T> c(m, name, text.c_str());
  BindPickles<T>(c, name);
  BindCopies(c);
  c.def(py::init([name](const py::kwargs& arguments) { return ReadParameters<T>(arguments, name); }));
  c.def("__repr__", &ShowCall<T>);
  BindValues<T>(c);
}

}  // namespace

void BindTools(py::module_& m) {
  ForEachKind([&m]<typename T>(const T&) { BindKind<T>(m); });
}

std::string ListToolClasses(const std::string& article) {
  std::string text;
  std::size_t left = std::variant_size_v<Tool>;
  ForEachKind([&]<typename T>(const T&) {
    --left;
    text += article + NameClass<T>() + (left > 1 ? ", " : left == 1 ? " or " : "");
  });
  return text;
}

int SenseOf(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) {
    if constexpr (kind.kDrive == DriveMotion::kRotation) return kind.kSense;
    return 1;
  });
}

Tool ToTool(const py::object& object) {
  Tool tool = DiscSaw{};
  bool found = object.is_none();
  ForEachKind([&]<typename T>(const T&) {
    if (!py::isinstance<T>(object)) return;
    tool = py::cast<T>(object);
    found = true;
  });
  if (!found) throw Error("tool must be " + ListToolClasses("a "));
  return tool;
}

}  // namespace kerf::python
