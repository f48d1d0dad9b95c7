// Reactions of the program to signals.
#pragma once

#include <atomic>

namespace kerf::cli {

/// From this call on, a signal that ends the program (SIGHUP, SIGINT, SIGTERM, unless ignored) first removes unfinished
/// files, and writing a file beyond the process's size limit fails (SIGXFSZ).
void HandleSignals();

/// From this call on, a signal that ends or stops the program, including its own faults, first switches off the force
/// of the haptic devices (DeviceServo::ReleaseAll). The exceptions are SIGKILL and SIGSTOP, which cannot be caught, and
/// a fault in the thread that serves a device: only that thread could switch the force off, and it blocks all signals.
void HandleSignalsOfDevices();

/// Ends the program immediately: releases devices and removes temporary files, but runs no destructors.
[[noreturn]] void EndAtOnceWith(int status);

/// While an instance exists, exit() ends the program immediately in the same way. On a fatal error a library may call
/// exit() (Xlib when its server is lost) while other threads still use objects that a normal exit would destroy.
class ExitsAtOnce {
 public:
  ExitsAtOnce();
  ~ExitsAtOnce();
  ExitsAtOnce(const ExitsAtOnce&) = delete;
  ExitsAtOnce& operator=(const ExitsAtOnce&) = delete;
};

/// Returns true if `file` is a terminal and the program is not in the background there, where reading would stop it.
bool MayReadTerminal(int file);

/// From this call on, the first SIGINT, SIGTERM or SIGHUP (unless ignored) sets the returned flag, for work that ends
/// itself safely. A second signal is handled as before. A repetition of the same signal within 0.25 s does not count as
/// a second one: timeout(1), and some shells, send each signal twice.
const std::atomic<bool>& CatchInterrupt();

}  // namespace kerf::cli
