#include "app/cli/lack_of_memory.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include "app/cli/signals.h"
#include "base/files/memory.h"

namespace kerf::cli {
namespace {

double free_GB = 0;
std::terminate_handler terminate_before = nullptr;

[[noreturn]] void Terminate() {
  if (const std::exception_ptr why = std::current_exception()) {
    try {
      std::rethrow_exception(why);
    } catch (const std::bad_alloc&) {
      EndWithoutMemory();
    } catch (const std::exception& e) {
      // As a thread that could not be started, in a destructor.
      std::fprintf(stderr, "kerf: %s\n", e.what());
      std::fflush(stdout);
      EndAtOnceWith(1);
    } catch (...) {  // as before
    }
  }
  terminate_before();
  std::abort();
}

}  // namespace

void HandleLackOfMemory() {
  try {
    free_GB = 1e-9 * static_cast<double>(LimitMemory());
  } catch (const std::bad_alloc&) {
    EndWithoutMemory();
  }
  terminate_before = std::set_terminate(Terminate);
  SetEndWithoutMemory(EndWithoutMemory);
}

void EndWithoutMemory() {
  // stderr has no buffer that would have to be made.
  std::fprintf(stderr, "kerf: not enough memory: %.1f GB were free; use larger voxels or a shorter run\n", free_GB);
  std::fflush(stdout);
  EndAtOnceWith(1);
}

}  // namespace kerf::cli
