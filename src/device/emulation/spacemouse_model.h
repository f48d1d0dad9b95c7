// Software model of a SpaceMouse.
#pragma once

#include <array>
#include <deque>

#include "device/devices/hid/spacemouse_driver.h"
#include "device/emulation/hid_face.h"
#include "device/emulation/usb_model.h"

namespace kerf {

/// While the cap is deflected, reports 1 and 2 are sent every 8 ms; after it has returned, each is sent again with
/// zeros. Report 3 is sent when a button changes. Otherwise, nothing is sent.
class SpaceMouseEmulation final : public UsbModel {
 public:
  /// `six_axes`: true if all axes are sent in one report of 13 bytes, as newer devices do.
  explicit SpaceMouseEmulation(std::uint16_t vendor = 0x046d, std::uint16_t product = 0xc626, bool six_axes = false);

  /// Raw axes, about -350 to 350: right, towards the user and down, and the rotations about these.
  void Push(const std::array<int, 6>& axes) { axes_ = axes; }
  void Press(std::uint32_t buttons) { buttons_ = buttons; }
  bool lamp() const { return lamp_; }

  std::vector<std::uint8_t> descriptors() const override { return MakeHidDescriptors(face_); }
  void Advance(double dt_s) override;
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data) override;
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) override;
  void PowerOn() override;

 private:
  void QueueAxes(std::uint8_t id, std::size_t first, std::size_t count);

  HidFace face_;
  bool six_axes_;
  std::array<int, 6> axes_{};
  std::uint32_t buttons_ = 0;
  bool lamp_ = false;
  std::array<int, 6> reported_axes_{};
  std::uint32_t reported_buttons_ = 0;
  double since_report_s_ = 0;
  std::deque<std::vector<std::uint8_t>> reports_;
};

}  // namespace kerf
