// USB bus within the process, into which device models are plugged, with simulated cable faults.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "device/devices/usb.h"
#include "device/emulation/usb_model.h"

namespace kerf {

/// Faults of the connection. The fractions are probabilities per packet, 0 to 1. They are drawn from `seed`, so the
/// faults are repeatable.
struct UsbFaults {
  std::uint64_t seed = 1;
  double drop_out = 0;   // packets to the device that are lost
  double drop_in = 0;    // packets from the device that are lost
  double duplicate = 0;  // packets from the device that arrive twice
  double truncate = 0;   // packets from the device that end early
  double corrupt = 0;    // packets from the device with one byte changed
  double delay = 0;      // packets from the device that arrive one read late
  bool stalled = false;  // no data arrives from the device
  bool unplugged = false;
  /// If set, every packet to the device is lost and its transfer ends with this result; packets from the device still
  /// arrive.
  std::optional<Transfer> out_ends{};
};

/// Time advances only in Advance() and while waiting: a read without data advances the model by its timeout.
class ModelBus final : public UsbBus {
 public:
  /// The model must outlive the bus.
  void PlugIn(UsbModel& model);
  /// Sets the faults of all devices.
  void SetFaults(const UsbFaults& faults);
  /// Plugs unplugged devices in again, with new addresses, and powers them on.
  void PlugInAgain();
  void SetProblem(UsbProblem problem) { problem_ = problem; }
  void Advance(double dt_s);

  std::vector<UsbDeviceInfo> List() override;
  UsbOpening Open(const UsbDeviceInfo& device, int interface_number) override;

 private:
  struct Socket;
  class Connection;
  std::vector<std::shared_ptr<Socket>> sockets_;
  UsbProblem problem_ = UsbProblem::kNone;
  int next_address_ = 2;
};

}  // namespace kerf
