#include "text.h"

#include "kerf/error.h"

namespace kerf::python {
namespace {

py::str OrThrow(PyObject* text) {
  if (text == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(text);
}

}  // namespace

py::str ShowText(const std::string& text) {
  return OrThrow(PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace"));
}

py::list ShowTexts(const std::vector<std::string>& texts) {
  py::list list;
  for (const std::string& text : texts) list.append(ShowText(text));
  return list;
}

void WarnOnce(const std::vector<std::string>& sentences, std::set<std::string>& shown) {
  for (const std::string& sentence : sentences) {
    std::string words = sentence;
    std::erase_if(words, [](char c) { return c >= '0' && c <= '9'; });
    if (!shown.insert(words).second) continue;
    // Level 1: the line that called kerf.
    if (PyErr_WarnEx(PyExc_UserWarning, py::cast<std::string>(ShowText(sentence)).c_str(), 1) == 0) continue;
    if (PyErr_ExceptionMatches(PyExc_ValueError) == 0) throw py::error_already_set();
    PyErr_Clear();  // sys.stderr is closed
  }
}

std::string ToUtf8(const py::handle& text) {
  py::ssize_t size = 0;
  if (const char* utf8 = PyUnicode_AsUTF8AndSize(text.ptr(), &size)) return {utf8, static_cast<std::size_t>(size)};
  if (PyErr_ExceptionMatches(PyExc_UnicodeEncodeError) == 0) throw py::error_already_set();
  const py::error_already_set error;
  const auto at = py::cast<py::ssize_t>(error.value().attr("start"));
  const py::object character = text[py::int_(at)];
  throw Error("a text is not valid Unicode; it has " +
              py::cast<std::string>(py::module_::import("builtins").attr("ascii")(character)) + " at position " +
              std::to_string(at));
}

py::str DecodeFileName(const std::string& name) {
  return OrThrow(PyUnicode_DecodeFSDefaultAndSize(name.data(), static_cast<py::ssize_t>(name.size())));
}

}  // namespace kerf::python
