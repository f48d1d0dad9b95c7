// A WoodenHaptics device made of numbers: its board's firmware, its motors and arm, and a mechanism that they move.
#pragma once

#include "device/devices/hid/wooden_driver.h"
#include "device/emulation/hid_face.h"
#include "device/emulation/mechanism.h"
#include "device/emulation/usb_model.h"

namespace kerf {

/// Reports come once a millisecond, of what is then; one that is not fetched is overwritten by the next. The watchdog
/// cuts the motors 0.5 s after the last packet, and each current is held to 3 A, as in the firmware.
class WoodenModel final : public UsbModel {
 public:
  /// The mechanism must outlive the model. `params` are what the device is; the driver's may differ.
  explicit WoodenModel(Mechanism& mechanism, const WoodenParams& params = {});

  std::vector<std::uint8_t> descriptors() const override { return MakeHidDescriptors(face_); }
  void Advance(double dt_s) override;
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data) override;
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) override;
  void PowerOn() override;

  Vec3 currents_mA() const { return currents_mA_; }  // in the motors now
  bool motors_on() const { return motors_on_; }
  std::uint64_t packets() const { return packets_; }  // from the host, of the right length

 private:
  Mechanism& mechanism_;
  WoodenParams params_;
  HidFace face_;
  Vec3 angles_{0};  // of the arm, the last that could be reached
  Vec3 currents_mA_{0};
  bool motors_on_ = false;
  double since_packet_s_ = 0;
  double since_report_s_ = 0;
  WoodenReport report_;
  bool has_report_ = false;
  std::uint64_t packets_ = 0;
};

}  // namespace kerf
