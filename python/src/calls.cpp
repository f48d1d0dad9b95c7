#include "calls.h"

#include <map>
#include <string>
#include <unordered_map>

namespace kerf::python {
namespace {

namespace py = pybind11;

/// pybind11's function that calls all others. They differ in their `self`.
PyCFunctionWithKeywords call = nullptr;
/// Names such as "Bone.block", by the `self` of the functions.
std::unordered_map<const PyObject*, std::string>& Names() {
  static std::unordered_map<const PyObject*, std::string> names;
  return names;
}

/// Replaces the TypeError that is set if pybind11 found that the arguments do not fit.
void Explain(PyObject* self, PyObject* arguments, PyObject* keywords) {
  py::error_already_set error;
  try {
    const std::string message = py::cast<std::string>(py::str(error.value()));
    const auto name = Names().find(self);
    if (name != Names().end() && (message.find("): incompatible function arguments. The following") < 200 ||
                                  message.find("): incompatible constructor arguments. The following") < 200)) {
      const py::object text = py::module_::import("kerf._calls")
                                  .attr("explain")(name->second, message, py::handle(arguments),
                                                   keywords == nullptr ? py::dict() : py::handle(keywords));
      PyErr_SetObject(PyExc_TypeError, text.ptr());
      return;
    }
  } catch (py::error_already_set&) {
    // The original message is better than none.
  } catch (const py::cast_error&) {
    // Likewise.
  }
  error.restore();
}

PyObject* CallAndExplain(PyObject* self, PyObject* arguments, PyObject* keywords) {
  PyObject* result = nullptr;
  try {
    result = call(self, arguments, keywords);
  } catch (
      py::error_already_set& error) {  // pybind11's message itself cannot be made, as with text that is not Unicode
    error.restore();
    return nullptr;
  }
  if (result == nullptr && PyErr_ExceptionMatches(PyExc_TypeError) != 0) Explain(self, arguments, keywords);
  return result;
}

/// Returns the compiled function of a method, a static method or a function; null if there is none.
PyObject* FindFunction(py::handle value) {
  if (PyInstanceMethod_Check(value.ptr())) value = PyInstanceMethod_GET_FUNCTION(value.ptr());
  py::object held;
  if (PyObject_TypeCheck(value.ptr(), &PyStaticMethod_Type)) {
    held = value.attr("__func__");  // the static method keeps it alive
    value = held;
  }
  return PyCFunction_Check(value.ptr()) ? value.ptr() : nullptr;
}

void Hook(const std::string& name, py::handle value) {
  PyObject* function = FindFunction(value);
  if (function == nullptr || (PyCFunction_GET_FLAGS(function) & (METH_VARARGS | METH_KEYWORDS)) == 0) return;
  PyMethodDef* definition = reinterpret_cast<PyCFunctionObject*>(function)->m_ml;
  const auto dispatcher = reinterpret_cast<PyCFunctionWithKeywords>(reinterpret_cast<void (*)()>(definition->ml_meth));
  if (call == nullptr) call = dispatcher;
  if (dispatcher != call) return;
  Names()[PyCFunction_GET_SELF(function)] = name;
  definition->ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&CallAndExplain));
}

/// Called for a class whose objects only kerf makes.
int RefuseToMake(PyObject* self, PyObject*, PyObject*) {
  const std::string name = py::cast<std::string>(py::type::handle_of(self).attr("__name__"));
  static const std::map<std::string, std::string> how{
      {"Bone", "make a bone with Bone.block(), plate(), mandible(), from_file(), from_labels() or read()"},
      {"Run", "kerf.run() and kerf.run_in_hand() return it"},
      {"SlabSimulation", "make one with SlabSimulation.from_scene()"},
      {"Tick", "Simulation.tick() returns it"},
      {"HandTick", "HandSimulation.tick() returns it"}};
  const auto found = how.find(name);
  const std::string text = name + "() can't be called" + (found == how.end() ? "" : "; " + found->second);
  PyErr_SetString(PyExc_TypeError, text.c_str());
  return -1;
}

}  // namespace

void ExplainWrongCalls(const py::module_& m) {
  for (const auto& [key, value] : py::cast<py::dict>(m.attr("__dict__"))) {
    const std::string name = py::cast<std::string>(key);
    Hook(name, value);
    if (!PyType_Check(value.ptr()) ||
        py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr())) == nullptr) {
      continue;
    }
    const py::dict members(value.attr("__dict__"));
    for (const auto& [member, function] : members) {
      const std::string own = py::cast<std::string>(member);
      std::string whole = name;
      if (own != "__init__") whole.append(".").append(own);
      Hook(whole, function);
    }
    // Without a constructor there is only the slot of pybind11, which says that there is none.
    if (FindFunction(members["__init__"]) == nullptr)
      reinterpret_cast<PyTypeObject*>(value.ptr())->tp_init = &RefuseToMake;
  }
}

}  // namespace kerf::python
