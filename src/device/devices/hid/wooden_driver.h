// WoodenHaptics-type devices over USB: reports of 8 bytes without an id, both ways. From the device three encoders and
// a counter, to it three currents in mA; 16-bit numbers, low byte first. Its firmware sends a report whenever the host
// asks, and cuts the motors half a second after the last packet.
#pragma once

#include <memory>
#include <span>

#include "device/devices/driver.h"
#include "device/devices/hid/wooden_kinematics.h"
#include "device/devices/usb.h"

namespace kerf {

inline constexpr std::uint16_t kWoodenVendor = 0x1234;  // mbed's own: other gadgets have it too
inline constexpr std::uint16_t kWoodenProduct = 0x0006;
inline constexpr std::uint8_t kWoodenIn = 0x81;
inline constexpr std::uint8_t kWoodenOut = 0x01;
inline constexpr std::size_t kWoodenReportBytes = 8;

/// Whether it may be one: Start() looks closer.
bool IsWoodenDevice(const UsbDeviceInfo& info);

struct WoodenReport {
  WoodenCounts counts{};
  std::uint16_t counter = 0;
};
/// False when it has not the right length.
bool ReadWoodenReport(std::span<const std::uint8_t> bytes, WoodenReport& report);
void WriteWoodenReport(const WoodenReport& report, std::span<std::uint8_t, kWoodenReportBytes> bytes);
/// Each within 16 bits.
void WriteWoodenCurrents(const Vec3& currents_mA, std::span<std::uint8_t, kWoodenReportBytes> bytes);
/// mA.
Vec3 ReadWoodenCurrents(std::span<const std::uint8_t, kWoodenReportBytes> bytes);

/// Of a joint: beyond, the 16 bits of its count go round within half a turn to either side.
inline constexpr double kWoodenMostCountsPerTurn = 65534;

/// Tells new reports from old, doubled and damaged ones: there is no check sum on the wire but USB's own.
class WoodenReportFilter {
 public:
  enum class Verdict : std::uint8_t { kNew, kOld, kBad };
  /// `counts_per_turn`: of each joint, with its gear; either sign.
  explicit WoodenReportFilter(const Vec3& counts_per_turn);
  /// kNew for a report that follows the last good one, or the last bad one: then what looked bad was true. A report
  /// follows another when its counter is 1 to kMostLost + 1 ahead and no joint has gone faster than a hand moves it.
  Verdict Judge(const WoodenReport& report);
  void Reset() { *this = WoodenReportFilter(most_counts_); }

  static constexpr int kMostLost = 1000;
  /// 31 rad/s in the 1 ms from one to the next: 7 m/s at the handle.
  static constexpr double kMostTurnsPerReport = 0.005;

 private:
  explicit WoodenReportFilter(const std::array<int, 3>& most_counts) : most_counts_(most_counts) {}
  bool Follows(const WoodenReport& before, const WoodenReport& after) const;

  std::array<int, 3> most_counts_;
  WoodenReport last_;
  WoodenReport doubtful_;
  bool has_last_ = false;
  bool has_doubtful_ = false;
};

class WoodenDriver final : public DeviceDriver {
 public:
  /// Throws Error when a gear or a number of counts is 0, a turn of a joint has more counts than the reports' 16 bits,
  /// or the arm can't reach the middle of its workspace.
  WoodenDriver(std::unique_ptr<UsbTransport> transport, const WoodenParams& params);
  ~WoodenDriver() override { WoodenDriver::Stop(); }

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double share)>& show) override;
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

 private:
  void CheckReportSizes();
  /// kSample: all of it has gone out.
  RoundEnd Send(const Vec3& currents_mA) noexcept;
  Vec3 CalcAngles() const noexcept;

  std::unique_ptr<UsbTransport> transport_;
  WoodenParams params_;
  DeviceProfile profile_;
  DriverTraits traits_;
  WoodenReportFilter filter_;
  WoodenCounts counts_{};  // of the last good report
  WoodenCounts zero_{};    // counts of the zero pose
  bool has_counts_ = false;
};

}  // namespace kerf
