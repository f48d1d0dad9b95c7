#include "long_work.h"

#include <atomic>
#include <thread>

#include "kerf/error.h"

namespace kerf::python {
namespace {

constexpr std::chrono::milliseconds kInterval{50};

std::atomic<bool> ending = false;
std::thread::id ending_thread;  // once the interpreter is ending
std::atomic<int> unlocked_count = 0;

/// Ends the use of Python by a thread that has outlived the interpreter: only daemon threads do.
[[noreturn]] void RestForever() {
  PyEval_SaveThread();
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

}  // namespace

Unlocked::Unlocked() {
  if (ending && std::this_thread::get_id() != ending_thread) RestForever();
  if (ending) throw Error("the interpreter is ending");
  ++unlocked_count;
  release_.emplace();
}

Unlocked::~Unlocked() {
  release_.reset();
  const bool rest = ending;
  --unlocked_count;
  if (rest) RestForever();
}

void Unlocked::EndWithInterpreter() {
  py::module_::import("atexit").attr("register")(py::cpp_function([] {
    ending_thread = std::this_thread::get_id();
    ending = true;
    const py::gil_scoped_release release;
    while (unlocked_count > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }));
  // A forked child has only the thread that forked, and that one holds the lock.
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function([] { unlocked_count = 0; }));
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

void Watch::Complete() noexcept {
  next_ = {};
  (*this)(1);
}

void Watch::End() {
  if (show_.is_none() || !py::hasattr(show_, "end")) return;
  show_.attr("end")();
}

}  // namespace kerf::python
