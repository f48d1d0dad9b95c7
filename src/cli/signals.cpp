#include "cli/signals.h"

#include <atomic>
#include <csignal>

#include "files/files.h"

namespace kerf::cli {
namespace {

extern "C" void RemoveTemporariesAndEnd(int number) {
  RemoveTemporaries();
  raise(number);  // SA_RESETHAND: ends the program once the handler returns
}

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void NoteInterrupt(int) {
  interrupted.store(true);
  HandleSignals();  // sigaction() may be called in a handler
}

}  // namespace

const std::atomic<bool>& CatchInterrupt() {
  for (const int number : {SIGHUP, SIGINT, SIGTERM}) {
    struct sigaction before {};
    if (sigaction(number, nullptr, &before) != 0 || before.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = NoteInterrupt;
    sigaction(number, &action, nullptr);
  }
  return interrupted;
}

void HandleSignals() {
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int number : {SIGHUP, SIGINT, SIGTERM}) {
    struct sigaction before {};
    if (sigaction(number, nullptr, &before) != 0 || before.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = RemoveTemporariesAndEnd;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(number, &action, nullptr);
  }
}

}  // namespace kerf::cli
