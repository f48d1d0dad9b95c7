#include "app/cli/lack_of_memory.h"

#include <cstdio>
#include <exception>
#include <new>

#include "app/cli/signals.h"
#include "base/files/memory.h"

namespace kerf::cli {
namespace {

double free_GB = 0;

[[noreturn]] void EndWithMessage(const char* what) {
  std::fprintf(stderr, "kerf: %s\n", what);
  std::fflush(stdout);
  EndAtOnceWith(1);
}

[[noreturn]] void Terminate() {
  const std::exception_ptr why = std::current_exception();
  // A running std::thread was destroyed. This has been observed after a single failed allocation
  // (tests/reliability/io_faults.py).
  if (!why) EndWithMessage("ended unexpectedly, probably because memory ran out");
  try {
    std::rethrow_exception(why);
  } catch (const std::bad_alloc&) {
    EndWithoutMemory();
  } catch (const std::exception& e) {
    EndWithMessage(e.what());  // for example, a thread could not be started in a destructor
  } catch (...) {
    EndWithMessage("ended by an unknown error");
  }
}

}  // namespace

void HandleLackOfMemory() {
  try {
    free_GB = 1e-9 * static_cast<double>(LimitMemory());
  } catch (const std::bad_alloc&) {
    EndWithoutMemory();
  }
  std::set_terminate(Terminate);
  SetBadAllocHandler(EndWithoutMemory);
}

void EndWithoutMemory() {
  // stderr is unbuffered, so nothing is allocated.
  std::fprintf(stderr, "kerf: not enough memory: %.1f GB were free; use larger voxels or a shorter run\n", free_GB);
  std::fflush(stdout);
  EndAtOnceWith(1);
}

}  // namespace kerf::cli
