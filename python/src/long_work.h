// Work that takes long: without the interpreter's lock, with progress, and ended by Ctrl-C.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <functional>
#include <optional>
#include <utility>

#include "kerf/error.h"

namespace kerf::python {

namespace py = pybind11;

/// Releases the interpreter's lock. The interpreter's end waits for those that exist: a thread that wants the lock back
/// later would end the process. From then on, other threads rest here until the process ends, and the thread that ends
/// the interpreter gets kerf::Error.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

  /// Makes the interpreter wait for all at its end.
  static void EndWithInterpreter();

 private:
  std::optional<py::gil_scoped_release> release_;
};

/// Shows progress and notices Ctrl-C, at most 20 times per second. For the thread that does the work.
class Watch {
 public:
  /// `progress`: None (a bar in a terminal or a notebook, if the work takes over two seconds), False, or a function
  /// that is called with the completed fraction.
  Watch(const py::object& progress, const char* label);
  /// Returns false if the work has to end: because of Ctrl-C or an exception of the function. Called without the
  /// interpreter's lock.
  bool operator()(double fraction) noexcept;
  /// Shows that all is done. Called without the interpreter's lock.
  void Complete() noexcept;
  /// Removes the bar.
  void End();
  /// Throws what the interpreter had raised, if anything.
  void RethrowRaised() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  py::object show_;
  std::chrono::steady_clock::time_point next_;
  std::exception_ptr raised_;
};

/// Runs `work(watch)` without the interpreter's lock.
template <typename Work>
auto RunLong(const py::object& progress, const char* label, Work&& work) {
  Watch watch(progress, label);
  try {
    auto result = [&] {
      const Unlocked unlocked;
      auto made = work(watch);
      watch.Complete();
      return made;
    }();
    watch.End();
    watch.RethrowRaised();
    return result;
  } catch (...) {
    watch.End();
    watch.RethrowRaised();
    throw;
  }
}

/// Returns a progress function for work that ends if it throws.
inline std::function<void(double)> ThrowToEnd(Watch& watch) {
  return [&watch](double fraction) {
    if (!watch(fraction)) throw Error("the work was cancelled");
  };
}

}  // namespace kerf::python
