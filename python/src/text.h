// Texts that may contain names of files, which need not be valid UTF-8.
#pragma once

#include <pybind11/pybind11.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kerf::python {

namespace py = pybind11;

/// Returns a text for people: bytes that are not UTF-8 become \xff.
py::str ShowText(const std::string& text);
py::list ShowTexts(const std::vector<std::string>& texts);
/// Shows sentences with Python's warnings.warn(), except those of `shown`, to which it adds them. Sentences that differ
/// only in their digits count as the same.
void WarnOnce(const std::vector<std::string>& sentences, std::set<std::string>& shown);
/// Returns a Python text in UTF-8. Throws kerf::Error if that cannot represent it: os.fsdecode(), for example, makes
/// surrogates of bytes that are not UTF-8.
std::string ToUtf8(const py::handle& text);
/// Returns the name of a file as Python's os.fsdecode() does, which os.fsencode() turns back into the same bytes.
py::str DecodeFileName(const std::string& name);

/// Argument of a function that Python calls: a text, for which ToUtf8() has a plain message, or bytes.
struct Text {
  std::string utf8;
};

}  // namespace kerf::python

template <>
struct pybind11::detail::type_caster<kerf::python::Text> {
  PYBIND11_TYPE_CASTER(kerf::python::Text, const_name("str"));
  bool load(handle given, bool) {
    if (PyUnicode_Check(given.ptr())) {
      value.utf8 = kerf::python::ToUtf8(given);
      return true;
    }
    make_caster<std::string> bytes;
    if (!bytes.load(given, false)) return false;
    value.utf8 = cast_op<std::string&&>(std::move(bytes));
    return true;
  }
};
