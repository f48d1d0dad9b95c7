#include "long_work.h"

namespace kerf::python {
namespace {

constexpr std::chrono::milliseconds kInterval{50};

}  // namespace

Watch::Watch(const py::object& progress, const char* label) : next_(std::chrono::steady_clock::now() + kInterval) {
  show_ = py::module_::import("kerf._progress").attr("make")(progress, label);
}

bool Watch::operator()(double fraction) noexcept {
  if (raised_) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return true;
  next_ = now + kInterval;
  const py::gil_scoped_acquire acquire;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!show_.is_none()) show_(fraction);
    return true;
  } catch (...) {
    raised_ = std::current_exception();
    return false;
  }
}

void Watch::End() {
  if (show_.is_none() || !py::hasattr(show_, "end")) return;
  show_.attr("end")();
}

}  // namespace kerf::python
