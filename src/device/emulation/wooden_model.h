// Software model of a WoodenHaptics device: its firmware, its motors and arm, and the mechanism that they move.
#pragma once

#include "device/devices/hid/wooden_driver.h"
#include "device/emulation/hid_face.h"
#include "device/emulation/mechanism.h"
#include "device/emulation/usb_model.h"

namespace kerf {

/// Produces a report of the current state every millisecond; a report that is not fetched is replaced by the next. As
/// in the firmware, the watchdog switches the motors off 0.5 s after the last packet, and each current is limited
/// to 3 A.
class WoodenModel final : public UsbModel {
 public:
  /// The mechanism must outlive the model. `params` describe the modelled device; the driver's parameters may differ.
  explicit WoodenModel(Mechanism& mechanism, const WoodenParams& params = {});

  std::vector<std::uint8_t> descriptors() const override { return MakeHidDescriptors(face_); }
  void Advance(double dt_s) override;
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data) override;
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) override;
  void PowerOn() override;

  Vec3 currents_mA() const { return currents_mA_; }  // the currents that flow in the motors
  bool motors_on() const { return motors_on_; }
  std::uint64_t packets() const { return packets_; }  // number of packets of the right length from the host

 private:
  Mechanism& mechanism_;
  WoodenParams params_;
  HidFace face_;
  Vec3 angles_{0};  // last angles of the arm at which the handle was within reach
  Vec3 currents_mA_{0};
  bool motors_on_ = false;
  double since_packet_s_ = 0;
  double since_report_s_ = 0;
  WoodenReport report_;
  bool has_report_ = false;
  std::uint64_t packets_ = 0;
};

}  // namespace kerf
