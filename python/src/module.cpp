// The Python module kerf._kerf: kerf's public headers as classes that take and give NumPy arrays.
#include "bindings.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "long_work.h"

namespace py = pybind11;

PYBIND11_MODULE(_kerf, m) {
  m.doc() = "Compiled part of kerf; use the package kerf.";
  auto error = py::register_exception<kerf::Error>(m, "Error", PyExc_RuntimeError);
  error.attr("__module__") = "kerf";
  error.attr("__doc__") = "Input or environment that kerf cannot work with. The message is one sentence.";
  m.attr("__version__") = kerf::VersionString();
  m.attr("commit") = kerf::CommitString();
  kerf::python::Unlocked::EndWithInterpreter();
  kerf::python::BindBone(m);
  kerf::python::BindScene(m);
  kerf::python::BindSimulations(m);
  kerf::python::BindRuns(m);
}
