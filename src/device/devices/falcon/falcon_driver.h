// The Novint Falcon: loads its firmware, asks it where it is, tells its motors what to do. See docs/falcon.md for what
// is known from where; none of it was tried on a real device.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device/devices/driver.h"
#include "device/devices/falcon/falcon_kinematics.h"
#include "device/devices/falcon/falcon_packet.h"
#include "device/devices/usb.h"

namespace kerf {

struct FalconOptions {
  /// Novint's own, which may not be passed on: the user has it. Empty: only a Falcon that runs already can be used.
  std::vector<std::uint8_t> firmware;
  /// Motor counts for a torque of 1 N mm in the sense of the angles. UNVERIFIED: libnifalcon sends 10000 for each N m,
  /// with the sign turned around (src/kinematic/FalconKinematicStamper.cpp); nothing says what a real motor makes of
  /// it.
  double motor_counts_per_Nmm = -10;
  /// That a motor is ever sent, all three shortened by one factor. Source: a comment in libnifalcon; UNVERIFIED.
  int most_motor_counts = 4096;
  /// Between two rounds. More has to be said by two reports in a row before it is believed: 100 counts in 1 ms are
  /// about 4 m/s.
  int most_leap_counts = 100;
  int timeout_ms = 10;  // DriverTraits::timeout_ms, 10 or more
};

/// Firmware of fewer or more bytes is none: the known files have 7 to 9 kB.
inline constexpr std::size_t kFalconLeastFirmwareBytes = 1024;
inline constexpr std::size_t kFalconMostFirmwareBytes = 32768;
/// How to hand it in, for messages.
inline constexpr const char* kFalconFirmwareOption = "--falcon-firmware FILE";
inline constexpr const char* kFalconFirmwareVariable = "KERF_FALCON_FIRMWARE";

/// Throws Error when these bytes, read from `file`, can't be a Falcon's firmware.
void CheckFalconFirmware(const std::vector<std::uint8_t>& firmware, const std::string& file);

class FalconDriver final : public DeviceDriver {
 public:
  /// Throws Error for firmware of an impossible size or options out of range. Interface kFalconInterface is open.
  FalconDriver(std::unique_ptr<UsbTransport> transport, FalconOptions options);
  ~FalconDriver() override;

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  /// Up to ten uploads of about 0.6 s each; of 6 s (30 greetings of 0.2 s) where the boot loader does not answer.
  void Start(const std::function<bool(const std::string& doing, double share)>& show) override;
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  /// Of the firmware that was handed in; empty with none.
  const std::string& firmware_sha256() const { return sha256_; }
  /// As they went out last.
  const std::array<int, 3>& motors() const { return motors_; }

 private:
  using Show = std::function<bool(const std::string& doing, double share)>;
  enum class Step : std::uint8_t { kDone, kFailed, kGone };
  Step Set(std::uint8_t request, std::uint16_t value) noexcept;
  Step SendAll(std::span<const std::uint8_t> bytes) noexcept;
  Step AwaitEcho(std::span<const std::uint8_t> bytes, bool skip_others) noexcept;
  Step EnterRunMode() noexcept;
  Step LooksAlive() noexcept;
  Step Greet(const std::function<void()>& tell);
  Step Upload(const Show& show, int attempt);
  void CalcMotors(const DriverCommand& command) noexcept;
  bool TakeReport(std::span<const std::uint8_t> bytes) noexcept;
  RoundEnd Judge(DriverSample& sample) noexcept;
  bool IsLeap(const FalconReport& from, const FalconReport& to) const noexcept;

  std::unique_ptr<UsbTransport> transport_;
  FalconOptions options_;
  DeviceProfile profile_;
  DriverTraits traits_;
  std::string sha256_;

  FalconPacketStream stream_;
  FalconReport report_;    // came last, in form
  FalconReport believed_;  // came last, and is plausible
  FalconReport doubted_;   // would be a leap
  bool has_believed_ = false;
  bool has_doubted_ = false;
  FalconForward forward_;
  bool has_place_ = false;  // forward_ is of this homing
  std::array<int, 3> motors_{};
  bool must_drain_ = true;
};

}  // namespace kerf
