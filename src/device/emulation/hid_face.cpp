#include "device/emulation/hid_face.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace kerf {
namespace {

constexpr std::size_t kDeviceBytes = 18, kConfigurationBytes = 9, kInterfaceBytes = 9, kHidBytes = 9;
constexpr std::uint8_t kHidDescriptor = 0x21, kReportDescriptor = 0x22;

std::uint8_t Low(std::size_t word) {
  return static_cast<std::uint8_t>(word & 0xff);
}
std::uint8_t High(std::size_t word) {
  return static_cast<std::uint8_t>(word >> 8 & 0xff);
}

}  // namespace

std::vector<std::uint8_t> MakeHidDescriptors(const HidFace& face) {
  constexpr std::size_t kEndpointBytes = 7;
  const std::size_t endpoints = face.out_packet > 0 ? 2 : 1;
  const std::size_t total = kConfigurationBytes + kInterfaceBytes + kHidBytes + endpoints * kEndpointBytes;
  const std::size_t report = face.report_descriptor.size();
  std::vector<std::uint8_t> bytes = {
      // Device: USB 2.0, class defined by the interface, 64 bytes for endpoint 0, one configuration.
      18, 1, 0, 2, 0, 0, 0, 64, Low(face.vendor), High(face.vendor), Low(face.product), High(face.product),
      Low(face.release), High(face.release), 0, 0, 0, 1,
      // Configuration 1: one interface, bus-powered, 100 mA.
      9, 2, Low(total), High(total), 1, 1, 0, 0x80, 50,
      // Interface 0: HID, no boot protocol.
      9, 4, 0, 0, Low(endpoints), 3, 0, 0, 0,
      // HID 1.11 with one report descriptor.
      9, kHidDescriptor, 0x11, 1, 0, 1, kReportDescriptor, Low(report), High(report),
      // Endpoint 0x81, interrupt.
      7, 5, 0x81, 3, Low(face.in_packet), High(face.in_packet), face.interval_ms};
  if (face.out_packet > 0) {
    const std::array<std::uint8_t, kEndpointBytes> out = {
        7, 5, 0x01, 3, Low(face.out_packet), High(face.out_packet), face.interval_ms};
    for (const std::uint8_t byte : out) bytes.push_back(byte);
  }
  return bytes;
}

Transfer AnswerHidRequest(const HidFace& face, std::uint8_t request_type, std::uint8_t request, std::uint16_t value,
                          std::span<std::uint8_t> data) {
  constexpr std::uint8_t kFromDevice = 0x80, kFromInterface = 0x81, kToInterface = 0x21;
  constexpr std::uint8_t kGetDescriptor = 6, kSetIdle = 0x0a, kSetProtocol = 0x0b;
  if (request_type == kToInterface && (request == kSetIdle || request == kSetProtocol)) return {TransferEnd::kOk, 0};
  if (request != kGetDescriptor || (request_type != kFromDevice && request_type != kFromInterface)) {
    return {TransferEnd::kStall, 0};
  }
  const auto give = [data](std::span<const std::uint8_t> bytes) {
    const std::size_t count = std::min(bytes.size(), data.size());
    std::copy_n(bytes.begin(), count, data.begin());
    return Transfer{TransferEnd::kOk, static_cast<int>(count)};
  };
  const std::vector<std::uint8_t> all = MakeHidDescriptors(face);
  const std::span<const std::uint8_t> bytes(all);
  switch (value >> 8) {
    case 1:
      return give(bytes.first(kDeviceBytes));
    case 2:
      return give(bytes.subspan(kDeviceBytes));
    case kHidDescriptor:
      return give(bytes.subspan(kDeviceBytes + kConfigurationBytes + kInterfaceBytes, kHidBytes));
    case kReportDescriptor:
      return give(face.report_descriptor);
    default:
      return {TransferEnd::kStall, 0};
  }
}

}  // namespace kerf
