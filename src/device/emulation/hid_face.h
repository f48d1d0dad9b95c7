// Descriptors and standard requests of a HID device.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "device/devices/usb.h"

namespace kerf {

struct HidFace {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::uint16_t release = 0x0100;
  std::vector<std::uint8_t> report_descriptor;
  std::uint16_t in_packet = 64;   // packet size of endpoint 0x81, bytes
  std::uint16_t out_packet = 64;  // packet size of endpoint 0x01; 0: no such endpoint
  std::uint8_t interval_ms = 1;
};

/// Returns the device, configuration, interface, HID and endpoint descriptors.
std::vector<std::uint8_t> MakeHidDescriptors(const HidFace& face);
/// Answers GET_DESCRIPTOR for device, configuration, HID and report, and accepts SET_IDLE and SET_PROTOCOL. Returns
/// kStall for other requests.
Transfer AnswerHidRequest(const HidFace& face, std::uint8_t request_type, std::uint8_t request, std::uint16_t value,
                          std::span<std::uint8_t> data);

}  // namespace kerf
