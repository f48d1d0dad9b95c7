// Haply's Inverse3 through the Inverse Service that its maker gives: JSON over a WebSocket on this machine. The service
// tells a state for each force that it is given.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "device/devices/driver.h"
#include "device/devices/haply/haply_message.h"

namespace kerf {

struct HaplyOptions {
  std::string address = "127.0.0.1";  // this machine's only
  std::uint16_t port = 10001;
  std::string device_id;  // "": the first that the service lists
  /// Middle of the workspace in the service's axes, mm. None: where the cursor is at Start().
  std::optional<Vec3> p_H_middle_mm;
  int timeout_ms = 20;          // of a round, 1 to 1000
  int start_timeout_ms = 3000;  // of each step of Start(), 1 to 60000
};

/// JSON and the WebSocket ask for memory: against the rule of DeviceDriver, Exchange() does so in each round. It is
/// called from the device's own thread, never from the tick, and the ways are short.
class HaplyDriver final : public DeviceDriver {
 public:
  /// Throws Error when an option is out of range or the address another machine's.
  explicit HaplyDriver(const HaplyOptions& options = {});
  ~HaplyDriver() override;

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double share)>& show) override;
  /// Waits for a message that comes after the force went out; one from before is told where none does.
  /// A message without the device is kNoAnswer, or kGone when kMostWithout of them came in a row. kNoAnswer too: one
  /// without the grip, where there was one at Start().
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  static constexpr int kMostWithout = 100;

 private:
  class Line;

  RoundEnd Take(const std::string& text, DriverSample& sample);

  HaplyOptions options_;
  DeviceProfile profile_;
  DriverTraits traits_;
  std::unique_ptr<Line> line_;
  HaplyState state_;
  Vec3 p_H_middle_mm_{0};
  int without_ = 0;
};

}  // namespace kerf
