// Real-time privileges of the loop's thread: requests them and reports which were granted. Low priority of others.
#pragma once

#include <string>

namespace kerf {

struct RealtimeGrants {
  bool fifo = false;  // SCHED_FIFO
  int priority = 0;   // of SCHED_FIFO
  bool locked = false;
  bool fine_timer = false;  // timer slack of 1 ns
  std::string scheduling;   // this and `memory`: one sentence each for the user
  std::string memory;
};

/// Requests SCHED_FIFO at `priority` (0: request no real-time priority) and a timer slack of 1 ns for the calling
/// thread.
void RequestPriority(int priority, RealtimeGrants& grants);
/// Lets all other threads run before the calling one, from now on.
void LowerPriority();
/// Locks all memory of the process in RAM until UnlockMemory(), including later allocations if the limit (ulimit -l)
/// permits.
void LockMemory(RealtimeGrants& grants);
void UnlockMemory();
/// Writes to the next `kTouchedStackBytes` bytes of the calling thread's stack, so that no tick causes a page fault
/// there.
inline constexpr int kTouchedStackBytes = 256 * 1024;
void TouchStack() noexcept;

}  // namespace kerf
