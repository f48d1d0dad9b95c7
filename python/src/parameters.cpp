#include "parameters.h"

#include <pybind11/stl.h>

#include "text.h"

namespace kerf::python {

std::string SuggestName(const std::string& name, const std::vector<std::string>& known) {
  const py::list near = py::module_::import("difflib").attr("get_close_matches")(name, py::cast(known), 1);
  if (!near.empty()) return "; did you mean '" + py::cast<std::string>(near[0]) + "'?";
  if (known.empty()) return "; there are none";
  std::string list;
  for (const std::string& other : known) list += (list.empty() ? "" : ", ") + other;
  return "; there are " + list;
}

py::object ParameterSetter::Take(const char* key) {
  if (!rest_.contains(key)) return {};
  return ToScalar(rest_.attr("pop")(key));
}

void ParameterSetter::SetText(const char* key, std::string& value) {
  known_.emplace_back(key);
  const py::object given = Take(key);
  if (!given) return;
  if (!py::isinstance<py::str>(given)) throw Error(std::string(key) + " must be a text");
  value = ToUtf8(given);
}

void ParameterSetter::operator()(const char* key, Quat& value, const char*) {
  known_.emplace_back(key);
  const py::object given = Take(key);
  if (!given) return;
  const auto array = TryArray<DoubleArray>(given);
  if (!array || array.ndim() != 1 || array.size() != 4) {
    throw Error(std::string(key) + " must have 4 numbers, a unit quaternion w, x, y, z");
  }
  const double* q = array.data();
  value = Quat(q[0], q[1], q[2], q[3]);
}

void ParameterSetter::CheckRest(const char* whose) const {
  if (rest_.empty()) return;
  const std::string key = ToUtf8(py::str(rest_.begin()->first));
  throw Error(std::string(whose) + " has no parameter '" + key + "'" + SuggestName(key, known_));
}

void ParameterLister::Add(const std::string& key, const std::string& value, const std::string& meaning,
                          const std::string& range) {
  text_ += "    " + key + " = " + value + "\n        " + meaning + (range.empty() ? "" : "; " + range) + "\n";
}

}  // namespace kerf::python
