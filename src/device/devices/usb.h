// USB as the protocols need it: what is plugged in, transfers to it. Whoever carries them (libusb, a model of a device
// in this process) stands behind these two interfaces.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kerf {

enum class TransferEnd : std::uint8_t {
  kOk,
  kTimeout,
  kGone,    // unplugged: nothing will ever come back
  kStall,   // the device refuses that request
  kFailed,  // all else; the next may go well
};

struct Transfer {
  TransferEnd end = TransferEnd::kFailed;
  int bytes = 0;  // that were moved, also where it did not end well
};

/// An open interface of a device. One thread at a time. Closed by the destructor, which gives the interface back. The
/// calls don't allocate, but wait for up to `timeout_ms` (1 or more): they are for a device's own thread, not for the
/// tick.
class UsbTransport {
 public:
  UsbTransport() = default;
  UsbTransport(const UsbTransport&) = delete;
  UsbTransport& operator=(const UsbTransport&) = delete;
  virtual ~UsbTransport() = default;

  /// A control transfer on endpoint 0. The direction is bit 7 of `request_type`: from the device when set.
  virtual Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                           std::span<std::uint8_t> data, int timeout_ms) noexcept = 0;
  /// Bulk or interrupt, as the endpoint is. OUT endpoints have bit 7 clear.
  virtual Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, int timeout_ms) noexcept = 0;
  /// One packet, or as many as fill `data`; give it a multiple of the endpoint's packet size. IN endpoints have bit 7
  /// set.
  virtual Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data, int timeout_ms) noexcept = 0;
};

/// A device that is plugged in.
struct UsbDeviceInfo {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  int bus = 0;
  int address = 0;      // on the bus; another one after plugging in again
  std::string ports{};  // "1-2.3": the socket that it is plugged into
  bool is_hid = false;  // has an interface of the HID class
};

enum class UsbProblem : std::uint8_t {
  kNone,
  kNoPermission,
  kBusy,  // another driver or program has the interface
  kGone,
  kOther,
};

struct UsbOpening {
  std::unique_ptr<UsbTransport> transport;  // null when there is a problem
  UsbProblem problem = UsbProblem::kNone;
  std::string detail;  // what the system said, a phrase
};

/// All that is plugged in. None of it is for the tick.
class UsbBus {
 public:
  UsbBus() = default;
  UsbBus(const UsbBus&) = delete;
  UsbBus& operator=(const UsbBus&) = delete;
  virtual ~UsbBus() = default;

  /// As it is now. Throws Error when USB itself can't be asked.
  virtual std::vector<UsbDeviceInfo> List() = 0;
  /// Opens a device and claims an interface of it, from the kernel's driver too where it is a HID one.
  virtual UsbOpening Open(const UsbDeviceInfo& device, int interface_number) = 0;
};

}  // namespace kerf
