#include "base/realtime/realtime.h"

#include "base/core/errno_text.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace kerf {
namespace {

/// Returns true if, with MCL_FUTURE, requests for memory beyond the limit are granted, as they are to a privileged
/// process. Otherwise such requests fail later, for example those for thread stacks and the bone's leaves.
bool CanExceedLockLimit() {
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

void RequestPriority(int priority, RealtimeGrants& grants) {
  grants.fine_timer = prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0;
  grants.fifo = false;
  grants.priority = 0;
  if (priority <= 0) {
    grants.scheduling = "SCHED_FIFO was not requested: the loop runs at normal priority.";
    return;
  }
  sched_param param{};
  param.sched_priority = priority;
  const int failed = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  if (failed != 0) {
    grants.scheduling = fmt::format(
        "SCHED_FIFO was refused ({}): the loop runs at normal priority and may be late; run as root or raise the limit "
        "(ulimit -r).",
        FormatErrno(failed));
    return;
  }
  grants.fifo = true;
  grants.priority = priority;
  grants.scheduling = fmt::format("SCHED_FIFO was granted, priority {}.", priority);
}

void LowerPriority() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), 19);
}

void LockMemory(RealtimeGrants& grants) {
  grants.locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  const bool later_too = grants.locked && CanExceedLockLimit();
  if (grants.locked && !later_too) {
    munlockall();
    grants.locked = mlockall(MCL_CURRENT) == 0;
  }
  grants.memory = later_too       ? "Memory is locked in RAM."
                  : grants.locked ? "Memory that existed at the start is locked in RAM; later memory is not, because "
                                    "locking is limited (ulimit -l)."
                                  : fmt::format(
                                        "Memory could not be locked in RAM ({}): a tick may have to wait for a "
                                        "page; run as root or raise the limit (ulimit -l).",
                                        FormatErrno(errno));
}

void UnlockMemory() {
  munlockall();
}

void TouchStack() noexcept {
  char stack[kTouchedStackBytes];
  std::memset(stack, 0, sizeof(stack));
  asm volatile("" : : "r"(&stack[0]) : "memory");  // keeps the compiler from removing the writes
}

}  // namespace kerf
