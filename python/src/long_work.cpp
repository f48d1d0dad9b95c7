#include "long_work.h"

#include <atomic>
#include <thread>

#include "kerf/error.h"

namespace kerf::python {
namespace {

constexpr std::chrono::milliseconds kInterval{50};

std::atomic<bool> ending = false;
std::atomic<int> unlocked_count = 0;

}  // namespace

Unlocked::Unlocked() {
  if (ending) throw Error("the interpreter is ending");
  ++unlocked_count;
  release_.emplace();
}

Unlocked::~Unlocked() {
  release_.reset();
  --unlocked_count;
}

void Unlocked::EndWithInterpreter() {
  py::module_::import("atexit").attr("register")(py::cpp_function([] {
    ending = true;
    const py::gil_scoped_release release;
    while (unlocked_count > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }));
}

Watch::Watch(const py::object& progress, const char* label) : next_(std::chrono::steady_clock::now() + kInterval) {
  show_ = py::module_::import("kerf._progress").attr("make")(progress, label);
}

bool Watch::operator()(double fraction) noexcept {
  if (raised_ || ending) return false;
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
