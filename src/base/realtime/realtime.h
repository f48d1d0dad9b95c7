// What the system grants the loop's thread, asked for and said plainly.
#pragma once

#include <string>

namespace kerf {

struct RealtimeGrants {
  bool fifo = false;  // SCHED_FIFO
  int priority = 0;   // of it
  bool locked = false;
  bool fine_timer = false;  // timer slack of 1 ns
  std::string scheduling;   // a sentence for people, each
  std::string memory;
};

/// For the calling thread: SCHED_FIFO at `priority` (0: not asked for) and timer slack of 1 ns.
void AskForPriority(int priority, RealtimeGrants& grants);
/// For the whole process: all memory, also what it takes from now on, stays in RAM. Keep it until UnlockMemory().
void LockMemory(RealtimeGrants& grants);
void UnlockMemory();
/// Writes to the calling thread's next `kStackTouched` bytes of stack, so that none of them is asked for in a tick.
inline constexpr int kStackTouched = 256 * 1024;
void TouchStack() noexcept;

}  // namespace kerf
