// A bus within the process with models of devices in its sockets, and all that goes wrong with cables.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "device/devices/usb.h"
#include "device/emulation/usb_model.h"

namespace kerf {

/// What can go wrong on the way. Shares are probabilities for each packet, 0 to 1, drawn from `seed`: the same each
/// time.
struct UsbFaults {
  std::uint64_t seed = 1;
  double drop_out = 0;   // packets to the device that never come there
  double drop_in = 0;    // packets from it
  double duplicate = 0;  // packets from it that come twice
  double truncate = 0;   // packets from it that end early
  double corrupt = 0;    // packets from it with a byte changed
  double delay = 0;      // packets from it that come one read later than they should
  bool stalled = false;  // nothing comes back at all
  bool unplugged = false;
  /// Each packet to it ends so, and none comes there, while its own go on coming.
  std::optional<Transfer> out_ends{};
};

/// Time passes only by Advance() and by waiting: a read that finds nothing moves the model on by its timeout.
class ModelBus final : public UsbBus {
 public:
  /// The model must outlive the bus.
  void PlugIn(UsbModel& model);
  /// Of all its devices.
  void SetFaults(const UsbFaults& faults);
  /// Unplugged devices are plugged in again, power and all, under another address.
  void PlugInAgain();
  void SetProblem(UsbProblem problem) { problem_ = problem; }
  void Advance(double dt_s);

  std::vector<UsbDeviceInfo> List() override;
  UsbOpening Open(const UsbDeviceInfo& device, int interface_number) override;

 private:
  struct Socket;
  class Line;
  std::vector<std::shared_ptr<Socket>> sockets_;
  UsbProblem problem_ = UsbProblem::kNone;
  int next_address_ = 2;
};

}  // namespace kerf
