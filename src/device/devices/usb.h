// USB interfaces for the device protocols: the list of devices, and transfers to and from one of them. They are
// implemented with libusb and by device models in this process.
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
  kGone,    // unplugged: no further answer will come
  kStall,   // the device refuses the request
  kFailed,  // any other failure; the next transfer may succeed
};

struct Transfer {
  TransferEnd end = TransferEnd::kFailed;
  int bytes = 0;  // number of bytes transferred, even if the transfer failed
};

/// Open interface of a device, used by one thread at a time. The destructor closes it and releases the interface. The
/// calls do not allocate, but wait up to `timeout_ms` (1 or more): they are for a device's own thread, not for the
/// tick.
class UsbTransport {
 public:
  UsbTransport() = default;
  UsbTransport(const UsbTransport&) = delete;
  UsbTransport& operator=(const UsbTransport&) = delete;
  virtual ~UsbTransport() = default;

  /// Control transfer on endpoint 0. Bit 7 of `request_type` is the direction; if it is set, data come from the device.
  virtual Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                           std::span<std::uint8_t> data, int timeout_ms) noexcept = 0;
  /// Bulk or interrupt transfer, depending on the endpoint. OUT endpoints have bit 7 clear.
  virtual Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, int timeout_ms) noexcept = 0;
  /// Reads one packet, or as many as fill `data`, whose size must be a multiple of the endpoint's packet size. IN
  /// endpoints have bit 7 set.
  virtual Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data, int timeout_ms) noexcept = 0;
};

/// USB device that is plugged in.
struct UsbDeviceInfo {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  int bus = 0;
  int address = 0;      // on the bus; changes when the device is plugged in again
  std::string ports{};  // port that it is plugged into, such as "1-2.3"
  bool is_hid = false;  // has an interface of class HID
};

enum class UsbProblem : std::uint8_t {
  kNone,
  kNoPermission,
  kBusy,  // another driver or program uses the interface
  kGone,
  kOther,
};

struct UsbOpening {
  std::unique_ptr<UsbTransport> transport;  // nullptr if there is a problem
  UsbProblem problem = UsbProblem::kNone;
  std::string detail;  // reason given by the system, as a phrase
};

/// All devices that are plugged in. Not for use in the tick.
class UsbBus {
 public:
  UsbBus() = default;
  UsbBus(const UsbBus&) = delete;
  UsbBus& operator=(const UsbBus&) = delete;
  virtual ~UsbBus() = default;

  /// Lists the current devices. Throws kerf::Error if USB cannot be queried.
  virtual std::vector<UsbDeviceInfo> List() = 0;
  /// Opens a device and claims one of its interfaces, detaching the kernel driver of an HID interface.
  virtual UsbOpening Open(const UsbDeviceInfo& device, int interface_number) = 0;
};

}  // namespace kerf
