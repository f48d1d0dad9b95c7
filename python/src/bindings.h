// The parts of the module, each in a file of its own.
#pragma once

#include <pybind11/pybind11.h>

namespace kerf::python {

void BindBone(pybind11::module_& m);
void BindScene(pybind11::module_& m);
void BindSimulations(pybind11::module_& m);
void BindRuns(pybind11::module_& m);

}  // namespace kerf::python
