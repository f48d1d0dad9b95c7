// USB constants of the Novint Falcon: an FT232 (serial port) connected to the device's processor. All values are from
// libnifalcon, src/comm/FalconCommLibUSB.cpp and linux/40-novint-falcon-udev.rules (revision f7c727a); the FTDI
// requests are those that it uses.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kerf {

inline constexpr std::uint16_t kFalconVendor = 0x0403;
inline constexpr std::uint16_t kFalconProduct = 0xcb48;
inline constexpr int kFalconInterface = 0;
inline constexpr std::uint8_t kFalconEndpointIn = 0x81;
inline constexpr std::uint8_t kFalconEndpointOut = 0x02;
inline constexpr std::size_t kFalconUsbPacketBytes = 64;
/// Length of the status at the start of every packet from the device. A packet without data contains only the status.
inline constexpr std::size_t kFtdiStatusBytes = 2;

/// Vendor requests of the FT232, all with kFtdiRequestType, index 0 and no data.
inline constexpr std::uint8_t kFtdiRequestType = 0x40;
enum FtdiRequest : std::uint8_t {
  kFtdiReset = 0,  // value 1 purges the receive buffer, 2 the transmit buffer
  kFtdiModemLines = 1,
  kFtdiFlowControl = 2,  // 0: none
  kFtdiBaud = 3,
  kFtdiFormat = 4,   // 8: 8 bits, no parity, one stop bit
  kFtdiLatency = 9,  // time after which a packet is sent to the host even if it is not full, ms
};
inline constexpr std::uint16_t kFtdiPurgeReceived = 1;
inline constexpr std::uint16_t kFtdiPurgeSending = 2;
inline constexpr std::uint16_t kFtdiDtrHigh = 0x0101;
inline constexpr std::uint16_t kFtdiDtrLow = 0x0100;
inline constexpr std::uint16_t kFtdiRtsLow = 0x0200;
inline constexpr std::uint16_t kFtdiFormat8N1 = 8;
/// Divisors that set the baud rate. The comments state the rate, baud.
inline constexpr std::uint16_t kFalconBaudBoot = 0x4138;  // 9600: greeting the boot loader
inline constexpr std::uint16_t kFalconBaudLoad = 0x0015;  // 142857: uploading the firmware
inline constexpr std::uint16_t kFalconBaudRun = 0x0002;   // 1.5 million: normal operation
inline constexpr std::uint16_t kFalconLatencyBoot_ms = 16;
inline constexpr std::uint16_t kFalconLatencyRun_ms = 1;
/// Greeting of the boot loader, and its answer (optionally preceded by a byte 00).
inline constexpr std::uint8_t kFalconHello[] = {0x0a, 0x43, 0x0d};
inline constexpr std::uint8_t kFalconHelloAnswer[] = {0x0a, 0x44, 0x2c, 0x0d};
/// Byte that is sent before the firmware. The boot loader echoes it.
inline constexpr std::uint8_t kFalconLoadMark = 0x41;
/// Size of a firmware chunk. The boot loader echoes each chunk.
inline constexpr std::size_t kFalconChunkBytes = kFalconUsbPacketBytes - kFtdiStatusBytes;

}  // namespace kerf
