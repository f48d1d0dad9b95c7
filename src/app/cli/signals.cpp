#include "app/cli/signals.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>

#include "base/files/files.h"
#include "base/realtime/loop_clock.h"
#include "device/drivers/device_servo.h"

namespace kerf::cli {
namespace {

constexpr int kReleaseTimeout_ms = 300;

}  // namespace

void EndAtOnceWith(int status) {
  DeviceServo::ReleaseAll(kReleaseTimeout_ms, true);
  RemoveTemporaries();
  std::_Exit(status);
}

namespace {

extern "C" void RemoveTemporariesAndEnd(int number) {
  DeviceServo::ReleaseAll(kReleaseTimeout_ms, true);
  RemoveTemporaries();
  raise(number);  // SA_RESETHAND: ends the program once the handler returns
}

std::atomic<bool> exits_at_once{false};

extern "C" void EndAtOnce(int status, void*) {
  if (exits_at_once.load()) EndAtOnceWith(status);
}

std::atomic<bool> interrupted{false};
std::atomic<std::int64_t> interrupted_ns{0};
std::atomic<int> interrupted_by{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);
constexpr std::int64_t kRepetition_ns = 250'000'000;

extern "C" void ReleaseAndEnd(int number) {
  DeviceServo::ReleaseAll(kReleaseTimeout_ms, true);
  raise(number);  // SA_RESETHAND
}

extern "C" void ReleaseAndStop(int) {
  DeviceServo::ReleaseAll(kReleaseTimeout_ms, false);
  raise(SIGSTOP);
}

extern "C" void NoteInterrupt(int number) {
  const std::int64_t now_ns = MonotonicClock().Now();  // clock_gettime() is safe in a signal handler
  if (!interrupted.load()) {
    interrupted_ns.store(now_ns);
    interrupted_by.store(number);
    interrupted.store(true);
    return;
  }
  if (number == interrupted_by.load() && now_ns - interrupted_ns.load() < kRepetition_ns) return;
  HandleSignals();  // sigaction() is safe in a signal handler
  raise(number);    // ends the program once this handler returns
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
  const auto handle = [](int number, void (*handler)(int), int flags) {
    struct sigaction before {};
    if (sigaction(number, nullptr, &before) != 0 || before.sa_handler == SIG_IGN) return;
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigaction(number, &action, nullptr);
  };
  const auto end = [&](int number) { handle(number, ReleaseAndEnd, static_cast<int>(SA_RESETHAND)); };
  // All signals that end a program (signal(7)) except those of CatchInterrupt() and HandleSignals().
  for (const int number : {SIGQUIT, SIGILL, SIGTRAP, SIGABRT, SIGBUS, SIGFPE, SIGSEGV, SIGUSR1, SIGUSR2, SIGPIPE,
                           SIGALRM, SIGSTKFLT, SIGXCPU, SIGVTALRM, SIGPROF, SIGIO, SIGPWR, SIGSYS}) {
    end(number);
  }
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) end(number);
  for (const int number : {SIGTSTP, SIGTTIN, SIGTTOU}) handle(number, ReleaseAndStop, SA_RESTART);
}

ExitsAtOnce::ExitsAtOnce() {
  static const int set = on_exit(EndAtOnce, nullptr);
  exits_at_once.store(set == 0);
}

ExitsAtOnce::~ExitsAtOnce() {
  exits_at_once.store(false);
}

bool MayReadTerminal(int file) {
  if (isatty(file) != 1) return false;
  const pid_t in_front = tcgetpgrp(file);
  return in_front == -1 || in_front == getpgrp();  // -1: not the controlling terminal of this program
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
