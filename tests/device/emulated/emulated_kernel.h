// Emulates the kernel's USB: models of devices behind the files and system calls that libusb uses, for this program and
// for programs that it starts.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "device/emulation/usb_model.h"

namespace kerf::test {

/// Restarts this program with umockdev's library preloaded (and the address sanitizer's before it), unless that library
/// is loaded already. To be called first in main(). Returns "" if the library is loaded, otherwise the reason why it
/// cannot be.
std::string RunUnderUmockdev(char** argv);

struct EmulatedSocket {
  bool no_permission = false;  // the device's file can't be opened
  std::string driver{};        // kernel driver that is bound to interface 0 at the start; none if empty
  bool driver_holds = false;   // the kernel driver can't be detached
};

/// An emulated kernel that runs in real time: models advance by the time since the last system call, and at least every
/// 5 ms.
class EmulatedKernel {
 public:
  /// Throws Error if umockdev is not loaded (RunUnderUmockdev).
  EmulatedKernel();
  ~EmulatedKernel();
  EmulatedKernel(const EmulatedKernel&) = delete;
  EmulatedKernel& operator=(const EmulatedKernel&) = delete;

  /// Plugs in a device and returns its socket, a zero-based index. The model must outlive the kernel.
  int PlugIn(UsbModel& model, const EmulatedSocket& socket = {});
  void Unplug(int socket);
  /// Plugs the device in again, after a loss of power and with a new address.
  void PlugInAgain(int socket);
  /// While a device is silent, no data come from it.
  void SetSilent(int socket, bool silent);
  /// Calls `what` while no model is moving, to inspect the models.
  void Look(const std::function<void()>& what);

  /// Number of system calls that the emulation does not support.
  int unknown_calls() const { return unknown_calls_; }

 private:
  struct Socket;
  struct Umockdev;
  void Attach(Socket& socket);
  void AdvanceAll();  // the caller holds the lock

  std::unique_ptr<Umockdev> umockdev_;
  std::vector<std::unique_ptr<Socket>> sockets_;
  std::vector<std::unique_ptr<Socket>> past_;  // unplugged, but possibly still open
  std::mutex mutex_;
  int next_address_ = 4;
  std::int64_t now_ns_ = 0;
  std::atomic<int> unknown_calls_{0};
  std::atomic<bool> end_{false};
  std::thread ticking_;
};

/// While an object exists, this thread opens only files that their owner may open, even if it runs as root.
class WithoutPrivileges {
 public:
  WithoutPrivileges();
  ~WithoutPrivileges();
  WithoutPrivileges(const WithoutPrivileges&) = delete;
  WithoutPrivileges& operator=(const WithoutPrivileges&) = delete;

 private:
  std::uint32_t effective_[2] = {0, 0};
};

}  // namespace kerf::test
