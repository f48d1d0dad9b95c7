// A device behind a bridge: a program of the user's that speaks to it by its maker's library (docs/bridge.md).
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
  /// Packets are neither secret nor signed: whoever can send to the bridge can move the device. So another machine
  /// only when the user says so.
  bool allow_remote = false;
  int timeout_ms = 10;  // of a round, 1 to 1000
  /// A state that answers a command sent longer ago is no answer, 1 to 1000: the force for it comes as late, and the
  /// coupling is fitted to some ms. 30 are three rounds that waited in vain, which a busy machine does now and then,
  /// and below the 50 after which there is no force. An answer to the newest command is as old as timeout_ms lets it
  /// be.
  int oldest_ms = 30;
  int start_timeout_ms = 2000;  // of the handshake, 1 to 60000
  std::uint32_t valid_ms = 50;  // how long the far side may go on by the last command, 1 to 1000
};

class BridgeDriver final : public DeviceDriver {
 public:
  /// Throws Error when an option is out of range, or the address another machine's and that is not allowed.
  explicit BridgeDriver(const BridgeOptions& options = {});
  ~BridgeDriver() override { BridgeDriver::Stop(); }

  /// Of no device in particular before Start().
  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  /// Shakes hands. Each time a new session.
  void Start(const std::function<bool(const std::string& doing, double share)>& show) override;
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  /// The force that the far side said it makes, N.
  Vec3 made_f_D_N() const { return made_f_D_N_; }
  std::uint64_t bad_packets() const { return bad_packets_; }
  /// States that answered too old a command.
  std::uint64_t late_states() const { return late_states_; }

 private:
  using Clock = std::chrono::steady_clock;

  BridgeHeader NextHeader() noexcept;
  /// Whether what answers that packet of ours tells how things are now.
  bool IsPrompt(std::uint32_t answer_to) const noexcept;
  void TakeDescription(const BridgeDescription& description);

  BridgeOptions options_;
  DeviceProfile profile_;
  DriverTraits traits_;
  std::unique_ptr<UdpLink> link_;
  std::uint32_t session_ = 0;
  std::uint32_t sequence_ = 0;
  std::uint32_t heard_sequence_ = 0;  // of the far side
  /// When our packets went out, by their sequence. Of 64 rounds: at 1 kHz, longer than oldest_ms by default.
  std::array<Clock::time_point, 64> sent_at_{};
  bool running_ = false;
  Vec3 made_f_D_N_{0};
  std::uint64_t bad_packets_ = 0;
  std::uint64_t late_states_ = 0;
};

}  // namespace kerf
