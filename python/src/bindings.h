// The parts of the module, each in a file of its own.
#pragma once

#include <pybind11/pybind11.h>

namespace kerf::python {

/// Member functions as functions of a reference: pybind11 checks that an object whose __init__ has not run is not used.
template <typename C, typename R>
auto Of(R (C::*get)() const) {
  return [get](const C& object) -> R { return (object.*get)(); };
}

void BindBone(pybind11::module_& m);
void BindScene(pybind11::module_& m);
void BindSimulations(pybind11::module_& m);
void BindRuns(pybind11::module_& m);

}  // namespace kerf::python
