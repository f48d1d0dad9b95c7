#include "base/realtime/realtime.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace kerf {
namespace {

std::string Reason(int number) {
  return std::generic_category().message(number);
}

/// With MCL_FUTURE: whether a request for memory that goes beyond the limit is granted, as to one who is above it, or
/// would now fail: for a thread's stack, for the bone's leaves.
bool IsAboveTheLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) != 0) return false;
  if (limit.rlim_cur == RLIM_INFINITY) return true;
  const std::size_t beyond = limit.rlim_cur + 4096;
  void* asked = mmap(nullptr, beyond, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (asked == MAP_FAILED) return false;
  munmap(asked, beyond);
  return true;
}

}  // namespace

void AskForPriority(int priority, RealtimeGrants& grants) {
  grants.fine_timer = prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0;
  grants.fifo = false;
  grants.priority = 0;
  if (priority <= 0) {
    grants.scheduling = "SCHED_FIFO was not asked for: the loop runs among the other threads.";
    return;
  }
  sched_param param{};
  param.sched_priority = priority;
  const int failed = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  if (failed != 0) {
    grants.scheduling = fmt::format(
        "SCHED_FIFO was refused ({}): the loop runs among the other threads and may be late; run as root or raise "
        "the limit (ulimit -r).",
        Reason(failed));
    return;
  }
  grants.fifo = true;
  grants.priority = priority;
  grants.scheduling = fmt::format("SCHED_FIFO was granted, priority {}.", priority);
}

void LockMemory(RealtimeGrants& grants) {
  grants.locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  const bool later_too = grants.locked && IsAboveTheLimit();
  if (grants.locked && !later_too) {
    munlockall();
    grants.locked = mlockall(MCL_CURRENT) == 0;
  }
  grants.memory = later_too       ? "Memory is locked in RAM."
                  : grants.locked ? "What memory there was at the start is locked in RAM; what comes later is not, as "
                                    "that is limited (ulimit -l)."
                                  : fmt::format(
                                        "Memory could not be locked in RAM ({}): a tick may have to wait for a "
                                        "page; run as root or raise the limit (ulimit -l).",
                                        Reason(errno));
}

void UnlockMemory() {
  munlockall();
}

void TouchStack() noexcept {
  char stack[kStackTouched];
  std::memset(stack, 0, sizeof(stack));
  asm volatile("" : : "r"(&stack[0]) : "memory");  // the compiler must not see that nobody reads it
}

}  // namespace kerf
