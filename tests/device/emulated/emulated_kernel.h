// A kernel's USB that is not there: models of devices behind the files and system calls that libusb uses, for this
// program and for those that it starts.
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

/// Runs this program anew with umockdev's library (and the address sanitizer's before it) in front of all others,
/// unless it is there already. To be called first in main(). Returns "" or why that can't be.
std::string RunUnderUmockdev(char** argv);

struct EmulatedSocket {
  bool no_permission = false;  // its file can't be opened
  std::string driver{};        // of the kernel, that has its interface 0 at the beginning
  bool driver_holds = false;   // and can't be made to let go
};

/// Time is the real one: models move on by what went by since the last system call, at least each 5 ms.
class EmulatedKernel {
 public:
  /// Throws Error outside of umockdev (RunUnderUmockdev).
  EmulatedKernel();
  ~EmulatedKernel();
  EmulatedKernel(const EmulatedKernel&) = delete;
  EmulatedKernel& operator=(const EmulatedKernel&) = delete;

  /// The model must outlive the kernel. Sockets count from 0.
  int PlugIn(UsbModel& model, const EmulatedSocket& socket = {});
  void Unplug(int socket);
  /// Power and all, under another address.
  void PlugInAgain(int socket);
  /// Nothing comes back from it any more.
  void SetSilent(int socket, bool silent);
  /// Runs `what` while no model is moving: for looking at them.
  void Look(const std::function<void()>& what);

  /// System calls that nobody here knows.
  int unknown_calls() const { return unknown_calls_; }

 private:
  struct Socket;
  struct Umockdev;
  void Attach(Socket& socket);
  void AdvanceAll();  // under the lock

  std::unique_ptr<Umockdev> umockdev_;
  std::vector<std::unique_ptr<Socket>> sockets_;
  std::vector<std::unique_ptr<Socket>> past_;  // unplugged, perhaps still open somewhere
  std::mutex mutex_;
  int next_address_ = 4;
  std::int64_t now_ns_ = 0;
  std::atomic<int> unknown_calls_{0};
  std::atomic<bool> end_{false};
  std::thread ticking_;
};

/// While one stands, this thread opens only files that its owner may open, even when it is root's.
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
