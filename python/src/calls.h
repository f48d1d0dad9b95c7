// Calls with wrong arguments: one clear sentence instead of pybind11's list of signatures and values.
#pragma once

#include <pybind11/pybind11.h>

namespace kerf::python {

/// Changes the messages of the TypeErrors of all functions and classes of the module. Call when all are defined.
void ExplainWrongCalls(const pybind11::module_& m);

}  // namespace kerf::python
