#include "cli/signals.h"

#include <atomic>
#include <csignal>

#include "drivers/device_servo.h"
#include "files/files.h"

namespace kerf::cli {
namespace {

constexpr int kLetGo_ms = 300;

extern "C" void RemoveTemporariesAndEnd(int number) {
  DeviceServo::LetGoOfAll(kLetGo_ms);
  RemoveTemporaries();
  raise(number);  // SA_RESETHAND: ends the program once the handler returns
}

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void LetGoAndEnd(int number) {
  DeviceServo::LetGoOfAll(kLetGo_ms);
  raise(number);  // SA_RESETHAND
}

extern "C" void LetGoAndStop(int) {
  DeviceServo::LetGoOfAll(kLetGo_ms);
  raise(SIGSTOP);
}

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

void HandleSignalsOfDevices() {
  struct sigaction action {};
  action.sa_handler = LetGoAndEnd;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int number : {SIGQUIT, SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTSTP}) {
    struct sigaction before {};
    if (sigaction(number, nullptr, &before) != 0 || before.sa_handler == SIG_IGN) continue;
    if (number == SIGTSTP) {
      action.sa_handler = LetGoAndStop;
      action.sa_flags = SA_RESTART;
    }
    sigaction(number, &action, nullptr);
  }
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
