// The tools: a class for each kind.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "kerf/tool.h"

namespace kerf::python {

namespace py = pybind11;

/// Defines the classes of the tools.
void BindTools(py::module_& m);
/// Returns the names of these classes: "Disc or Ball". `article`: stands before each, such as "a ".
std::string ListToolClasses(const std::string& article = "");
/// Returns the tool; for None the default disc. Throws kerf::Error if the object is not a tool.
Tool ToTool(const py::object& tool);
/// Returns the sign of the spindle speed at which a tool cuts forwards.
int SenseOf(const Tool& tool);

}  // namespace kerf::python
