// Driver of a device behind a bridge: a user-supplied program that accesses the device through its maker's library
// (docs/bridge.md).
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <string>

#include "device/devices/bridge/bridge_packet.h"
#include "device/devices/driver.h"
#include "device/drivers/udp_link.h"

namespace kerf {

struct BridgeOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = kBridgePort;
  /// If true, the bridge may be on another machine. Packets are neither encrypted nor signed: any program that can send
  /// to the bridge can move the device.
  bool allow_remote = false;
  int timeout_ms = 10;
  /// Maximum age of the command that a state answers. A state that answers an older command is discarded:
  /// its force would be just as late, and the coupling is designed for a delay of a few ms. 30 ms corresponds to three
  /// consecutive timeouts, which occasionally occur on a busy machine, and is less than the 50 ms after which there is
  /// no force. An answer to the newest command may be as old as timeout_ms permits.
  int max_age_ms = 30;
  int start_timeout_ms = 2000;  // of the handshake
  std::uint32_t valid_ms = 50;
};
template <typename V>
void Describe(BridgeOptions& p, V&& visit) {
  DescribeLink(p, visit);
  visit("max_age_ms", p.max_age_ms, kTimeoutRange_ms, "maximum age of the command that a state answers");
  visit("valid_ms", p.valid_ms, kTimeoutRange_ms, "time for which the bridge may continue with the last command");
}

class BridgeDriver final : public DeviceDriver {
 public:
  /// Throws kerf::Error if an option is out of range, or if the address is that of another machine and allow_remote is
  /// false.
  explicit BridgeDriver(const BridgeOptions& options = {});
  ~BridgeDriver() override { BridgeDriver::Stop(); }

  /// Returns a generic profile before Start().
  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  /// Performs the handshake. Each call begins a new session.
  void Start(const std::function<bool(const std::string& doing, double fraction)>& show) override;
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  /// Force that the bridge reported as its output, N.
  Vec3 actual_f_D_N() const { return actual_f_D_N_; }
  std::uint64_t bad_packets() const { return bad_packets_; }
  /// Number of states that were discarded because they answered too old a command.
  std::uint64_t late_states() const { return late_states_; }

 private:
  using Clock = std::chrono::steady_clock;

  BridgeHeader NextHeader() noexcept;
  /// Returns true if an answer to the packet `answer_to` is recent enough to describe the current state.
  bool IsPrompt(std::uint32_t answer_to) const noexcept;
  void TakeDescription(const BridgeDescription& description);

  BridgeOptions options_;
  DeviceProfile profile_;
  DriverTraits traits_;
  std::unique_ptr<UdpLink> link_;
  std::uint32_t session_ = 0;
  std::uint32_t sequence_ = 0;
  std::uint32_t heard_sequence_ = 0;  // last sequence number received from the bridge
  /// Send times of the last 64 packets, by sequence number. At 1 kHz, they cover more than the default max_age_ms.
  std::array<Clock::time_point, 64> sent_at_{};
  bool running_ = false;
  Vec3 actual_f_D_N_{0};
  std::uint64_t bad_packets_ = 0;
  std::uint64_t late_states_ = 0;
};

}  // namespace kerf
