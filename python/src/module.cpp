// The Python module kerf._kerf: kerf's public headers as classes that take and give NumPy arrays.
#include <cstddef>
#include <exception>
#include <utility>

#include "bindings.h"
#include "calls.h"
#include "forks.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "long_work.h"
#include "text.h"

namespace py = pybind11;

namespace {

PyObject* error_type = nullptr;

void BindError(py::module_& m) {
  py::exception<kerf::Error> error(m, "Error", PyExc_RuntimeError);
  error.attr("__module__") = "kerf";
  error.attr("__doc__") = "Input or environment that kerf cannot work with. The message is one sentence.";
  error_type = error.inc_ref().ptr();
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(std::move(thrown));
    } catch (const kerf::Error& e) {
      PyErr_SetObject(error_type, kerf::python::ShowText(e.what()).ptr());
    }
  });
}

/// Makes the use of objects whose __init__ was not called raise TypeError. pybind11 2.10 would give the function
/// uninitialised memory, which it takes from this hook.
void RefuseObjectsWithoutInit(const py::module_& m) {
  for (const auto& [name, value] : py::cast<py::dict>(m.attr("__dict__"))) {
    if (!PyType_Check(value.ptr())) continue;
    py::detail::type_info* info = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr()));
    if (info == nullptr) continue;
    info->operator_new = [](std::size_t) -> void* {
      throw py::type_error("the object was not made completely: its __init__ was not called");
    };
  }
}

}  // namespace

PYBIND11_MODULE(_kerf, m) {
  m.doc() = "Compiled part of kerf; use the package kerf.";
  BindError(m);
  m.attr("__version__") = kerf::VersionString();
  m.attr("commit") = kerf::CommitString();
  kerf::python::PrepareForks();
  kerf::python::Unlocked::EndWithInterpreter();
  kerf::python::BindBone(m);
  kerf::python::BindScene(m);
  kerf::python::BindSimulations(m);
  kerf::python::BindRuns(m);
  RefuseObjectsWithoutInit(m);
  kerf::python::ExplainWrongCalls(m);
}
