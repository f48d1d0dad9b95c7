// Copies of objects that cannot be changed.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "kerf/error.h"

namespace kerf::python {

namespace py = pybind11;

/// Makes copy.copy() and copy.deepcopy() return the object itself.
template <typename Class>
void BindCopies(Class& c) {
  c.def("__copy__", [](const py::object& self) { return self; });
  c.def(
      "__deepcopy__", [](const py::object& self, const py::dict&) { return self; }, py::arg("memo"));
}

/// Makes an object of the state that a pickle contains. Throws kerf::Error if it is not such a state.
template <typename Make>
auto OfState(const char* whose, Make&& make) {
  const auto refuse = [whose] { return Error("this is not the state of a pickled " + std::string(whose)); };
  try {
    return make();
  } catch (const py::cast_error&) {
    throw refuse();
  } catch (py::error_already_set& e) {
    if (!e.matches(PyExc_IndexError) && !e.matches(PyExc_TypeError)) throw;
  }
  throw refuse();
}

}  // namespace kerf::python
