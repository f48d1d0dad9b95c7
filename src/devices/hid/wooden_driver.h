// WoodenHaptics-type devices over USB: reports of 8 bytes without an id, both ways. From the device three encoders and
// a counter, to it three currents in mA; 16-bit numbers, low byte first. Its firmware sends a report whenever the host
// asks, and cuts the motors half a second after the last packet.
#pragma once

#include <memory>
#include <span>

#include "devices/driver.h"
#include "devices/hid/wooden_kinematics.h"
#include "devices/usb.h"

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

/// Tells new reports from old, doubled and damaged ones: there is no check sum on the wire but USB's own.
class WoodenReportFilter {
 public:
  enum class Verdict : std::uint8_t { kNew, kOld, kBad };
  /// kNew for a report that follows the last good one, or the last bad one: then what looked bad was true. A report
  /// follows another when its counter is 1 to kMostLost + 1 ahead and no joint has gone faster than a hand moves it.
  Verdict Judge(const WoodenReport& report);
  std::uint64_t lost() const { return lost_; }
  void Reset() { *this = {}; }

  static constexpr int kMostLost = 1000;
  /// 160 of 32,000 counts for a turn of the joint in 1 ms are 31 rad/s: 7 m/s at the handle.
  static constexpr int kMostCountsPerReport = 160;

 private:
  static bool Follows(const WoodenReport& before, const WoodenReport& after);

  WoodenReport last_;
  WoodenReport doubtful_;
  bool has_last_ = false;
  bool has_doubtful_ = false;
  std::uint64_t lost_ = 0;
};

class WoodenDriver final : public DeviceDriver {
 public:
  /// Throws Error when a gear or a number of counts is 0, or the arm can't reach the middle of its workspace.
  WoodenDriver(std::unique_ptr<UsbTransport> transport, const WoodenParams& params);
  ~WoodenDriver() override { WoodenDriver::Stop(); }

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double share)>& show) override;
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  std::uint64_t lost_reports() const { return filter_.lost(); }

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
