// Driver of WoodenHaptics-type devices over USB: 8-byte reports without an id in both directions. The device sends
// three encoder counts and a counter; the host sends three currents in mA. All numbers have 16 bits, low byte first.
// The firmware sends a report whenever the host asks for one, and switches the motors off half a second after the last
// packet.
#pragma once

#include <memory>
#include <span>

#include "device/devices/driver.h"
#include "device/devices/hid/wooden_kinematics.h"
#include "device/devices/usb.h"

namespace kerf {

inline constexpr std::uint16_t kWoodenVendor = 0x1234;  // mbed's vendor ID, also used by other gadgets
inline constexpr std::uint16_t kWoodenProduct = 0x0006;
inline constexpr std::uint8_t kWoodenIn = 0x81;
inline constexpr std::uint8_t kWoodenOut = 0x01;
inline constexpr std::size_t kWoodenReportBytes = 8;

struct WoodenReport {
  WoodenCounts counts{};
  std::uint16_t counter = 0;
};
/// Returns false if the length is wrong.
bool ReadWoodenReport(std::span<const std::uint8_t> bytes, WoodenReport& report);
void WriteWoodenReport(const WoodenReport& report, std::span<std::uint8_t, kWoodenReportBytes> bytes);
/// Clamps each current to 16 bits.
void WriteWoodenCurrents(const Vec3& currents_mA, std::span<std::uint8_t, kWoodenReportBytes> bytes);
/// Returns the currents, mA.
Vec3 ReadWoodenCurrents(std::span<const std::uint8_t, kWoodenReportBytes> bytes);

/// Maximum number of counts per turn of a joint. With more, 16-bit counts wrap around within half a turn in either
/// direction.
inline constexpr double kWoodenMaxCountsPerTurn = 65534;

/// Distinguishes new reports from old, repeated and damaged ones; the protocol has no checksum except that of USB.
class WoodenReportFilter {
 public:
  enum class Verdict : std::uint8_t { kNew, kOld, kBad };
  /// `counts_per_turn`: encoder counts per turn of each joint, including its gear, with either sign.
  explicit WoodenReportFilter(const Vec3& counts_per_turn);
  /// Returns kNew for the first report, and for a report that follows the last good one or the last bad one, which was
  /// then valid after all. A report follows another if its counter is 1 to kMaxLost + 1 ahead and no joint has moved
  /// faster than a hand can move it.
  Verdict Judge(const WoodenReport& report);
  void Reset() { *this = WoodenReportFilter(max_counts_); }

  static constexpr int kMaxLost = 1000;
  /// Corresponds to 31 rad/s at 1 ms between reports, or 7 m/s at the handle.
  static constexpr double kMaxTurnsPerReport = 0.005;

 private:
  explicit WoodenReportFilter(const std::array<int, 3>& max_counts) : max_counts_(max_counts) {}
  bool Follows(const WoodenReport& before, const WoodenReport& after) const;

  std::array<int, 3> max_counts_;
  WoodenReport last_;
  WoodenReport doubtful_;
  bool has_last_ = false;
  bool has_doubtful_ = false;
};

class WoodenDriver final : public DeviceDriver {
 public:
  /// Throws kerf::Error if a gear or a number of counts is 0, a turn of a joint has more counts than 16 bits can hold,
  /// or the arm cannot reach the middle of its workspace.
  WoodenDriver(std::unique_ptr<UsbTransport> transport, const WoodenParams& params);
  ~WoodenDriver() override { WoodenDriver::Stop(); }

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double fraction)>& show) override;
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

 private:
  void CheckReportSizes();
  /// Returns kSample if all bytes were sent.
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
