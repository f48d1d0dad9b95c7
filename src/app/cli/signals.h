// What the program does when it is told to end.
#pragma once

#include <atomic>

namespace kerf::cli {

/// From now on a signal that ends the program (SIGHUP, SIGINT, SIGTERM; those that are ignored stay so) removes what is
/// half written first, and a file that grows beyond the process's limit fails to be written (SIGXFSZ).
void HandleSignals();

/// From now on a signal that ends or stops the program, a fault of its own included, takes the force from the haptic
/// devices first (DeviceServo::LetGoOfAll). Not SIGKILL and SIGSTOP, which nobody can catch, nor a fault of the thread
/// that serves a device: it alone could, and blocks all signals.
void HandleSignalsOfDevices();

/// Ends the program at once: devices are let go, temporaries removed, nothing is taken down.
[[noreturn]] void EndAtOnceWith(int status);

/// While one stands, exit() ends the program at once, after the same: a library that gives up calls it (Xlib, whose
/// server is gone) while threads of ours still use what the program would take down.
class ExitsAtOnce {
 public:
  ExitsAtOnce();
  ~ExitsAtOnce();
  ExitsAtOnce(const ExitsAtOnce&) = delete;
  ExitsAtOnce& operator=(const ExitsAtOnce&) = delete;
};

/// It is a terminal, and this program is not in its background, where who reads it is stopped.
bool MayReadTerminal(int file);

/// From now on the first SIGINT, SIGTERM or SIGHUP (those that are ignored stay so) sets this to true, for work that
/// ends itself safely; a second one is handled as before. The same one again within a quarter of a second is no second
/// one: timeout(1), and a shell beside its job, tell the program of each signal twice.
const std::atomic<bool>& CatchInterrupt();

}  // namespace kerf::cli
