// Driver of Haply's Inverse3 through its maker's Inverse Service, which sends JSON over a WebSocket on this machine and
// answers each force with a state.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "device/devices/driver.h"
#include "device/devices/haply/haply_message.h"

namespace kerf {

struct HaplyOptions {
  std::string address = "127.0.0.1";  // must be this machine
  std::uint16_t port = 10001;
  std::string device_id;  // "": the first device that the service lists
  /// Middle of the workspace in the service's axes, mm. If not set, the cursor position at Start() is used.
  std::optional<Vec3> p_H_middle_mm;
  int timeout_ms = 20;
  int start_timeout_ms = 3000;  // of each step of Start()
};
template <typename V>
void Describe(HaplyOptions& p, V&& visit) {
  DescribeLink(p, visit);
}

/// This driver is an exception to the rule of DeviceDriver: JSON and the WebSocket allocate in each Exchange(). It is
/// called from the device's thread, never from the tick, and the messages are short.
class HaplyDriver final : public DeviceDriver {
 public:
  /// Throws kerf::Error if an option is out of range or the address is that of another machine.
  explicit HaplyDriver(const HaplyOptions& options = {});
  ~HaplyDriver() override;

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double fraction)>& show) override;
  /// Waits for a message that arrives after the force was sent; if none does, uses one that arrived before. If the
  /// message does not contain the device, returns kNoAnswer, or kGone after kMaxMissing such messages in a row. If it
  /// does not contain the grip, returns kNoAnswer if a grip was present at Start().
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  static constexpr int kMaxMissing = 100;

 private:
  class Connection;

  RoundEnd Take(const std::string& text, DriverSample& sample);

  HaplyOptions options_;
  DeviceProfile profile_;
  DriverTraits traits_;
  std::unique_ptr<Connection> connection_;
  HaplyState state_;
  Vec3 p_H_middle_mm_{0};
  int missing_ = 0;
};

}  // namespace kerf
