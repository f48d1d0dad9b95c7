// Driver of the Novint Falcon: loads its firmware, reads its position and commands its motors. docs/falcon.md lists the
// source of each value. Not tested on a real device.
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
  /// Novint's firmware, which kerf may not distribute; the user supplies it. If it is empty, only a Falcon that already
  /// runs its firmware can be used.
  std::vector<std::uint8_t> firmware;
  /// Motor counts for a torque of 1 N mm in the direction of the angles. UNVERIFIED: libnifalcon sends 10000 per N m
  /// with the opposite sign (src/kinematic/FalconKinematicStamper.cpp); the response of a real motor is not documented.
  double motor_counts_per_Nmm = -10;
  /// Maximum count sent to a motor. If one motor would exceed it, all three counts are reduced by the same factor.
  /// Source: a comment in libnifalcon; UNVERIFIED.
  int max_motor_counts = 4096;
  /// Maximum change of an encoder count between two rounds. A larger change is accepted only if two consecutive reports
  /// agree. 100 counts in 1 ms correspond to about 4 m/s.
  int max_jump_counts = 100;
  int timeout_ms = 10;  // DriverTraits::timeout_ms
};
template <typename V>
void Describe(FalconOptions& p, V&& visit) {
  visit("max_motor_counts", p.max_motor_counts, Range{0, 4096}, "maximum count sent to a motor");
  visit("max_jump_counts", p.max_jump_counts, Range{1, 1 << 30},
        "maximum change of an encoder count between two rounds");
  visit("timeout_ms", p.timeout_ms, Range{10, kTimeoutRange_ms.upper}, "timeout of a round");
}

/// Limits of a valid firmware size, bytes. The known firmware files are 7 to 9 kB long.
inline constexpr std::size_t kFalconMinFirmwareBytes = 1024;
inline constexpr std::size_t kFalconMaxFirmwareBytes = 32768;
/// The ways in which the user can supply the firmware, for messages.
inline constexpr const char* kFalconFirmwareOption = "--falcon-firmware FILE";
inline constexpr const char* kFalconFirmwareVariable = "KERF_FALCON_FIRMWARE";

/// Throws kerf::Error if these bytes, read from `file`, cannot be Falcon firmware.
void CheckFalconFirmware(const std::vector<std::uint8_t>& firmware, const std::string& file);

class FalconDriver final : public DeviceDriver {
 public:
  /// `transport` must have interface kFalconInterface open. Throws kerf::Error if the firmware size is invalid or an
  /// option is out of range.
  FalconDriver(std::unique_ptr<UsbTransport> transport, FalconOptions options);
  ~FalconDriver() override;

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  /// Uploads the firmware in at most ten attempts. Each takes about 0.6 s, or 6 s (30 greetings of 0.2 s) if the boot
  /// loader does not answer.
  void Start(const std::function<bool(const std::string& doing, double fraction)>& show) override;
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  /// SHA-256 hash of the supplied firmware; empty if there is none.
  const std::string& firmware_sha256() const { return sha256_; }
  /// The motor counts that were sent last.
  const std::array<int, 3>& motors() const { return motors_; }

 private:
  using Show = std::function<bool(const std::string& doing, double fraction)>;
  enum class Step : std::uint8_t { kDone, kFailed, kGone };
  Step Set(std::uint8_t request, std::uint16_t value) noexcept;
  Step SendAll(std::span<const std::uint8_t> bytes) noexcept;
  Step AwaitEcho(std::span<const std::uint8_t> bytes, bool skip_others) noexcept;
  Step EnterRunMode() noexcept;
  Step LooksAlive() noexcept;
  Step Greet(const std::function<void()>& report_progress);
  Step Upload(const Show& show, int attempt);
  void CalcMotors(const DriverCommand& command) noexcept;
  bool TakeReport(std::span<const std::uint8_t> bytes) noexcept;
  RoundEnd Judge(DriverSample& sample) noexcept;
  bool IsJump(const FalconReport& from, const FalconReport& to) const noexcept;

  std::unique_ptr<UsbTransport> transport_;
  FalconOptions options_;
  DeviceProfile profile_;
  DriverTraits traits_;
  std::string sha256_;

  FalconPacketStream stream_;
  FalconReport report_;    // last well-formed report
  FalconReport accepted_;  // last plausible report
  FalconReport doubtful_;  // report that has not been accepted yet, because it implies a jump
  bool has_accepted_ = false;
  bool has_doubtful_ = false;
  FalconForward forward_;
  bool has_position_ = false;  // forward_ has been solved since the device was homed
  std::array<int, 3> motors_{};
  bool must_drain_ = true;
};

}  // namespace kerf
