// A tracked tool as a device: a peer sends its pose, and it holds the saw without giving a force back.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>

#include "device/devices/driver.h"
#include "device/devices/servo_round.h"

namespace kerf {

/// Name for --device.
inline constexpr const char* kTrackedToolName = "igtl";

/// Newest pose that a peer has sent. All functions may be called in any thread.
class TrackedTool {
 public:
  /// Takes the content of a TRANSFORM. Throws kerf::Error as ReadIgtlTransform() does, and for a place outside of the
  /// world; the driver then has a bad answer.
  void Take(std::span<const std::uint8_t> content);
  /// Returns what has arrived since the last call: its result, and the newest pose if that is kSample.
  RoundEnd Fetch(Pose& X_WH) noexcept;

 private:
  std::mutex mutex_;  // held for a few copies only
  Pose X_WH_;
  bool fresh_ = false;
  bool bad_ = false;
};

/// Which of several peers holds the tracked tool: the first one, until it is gone or silent. Used in one thread.
class ToolHolder {
 public:
  using Clock = std::chrono::steady_clock;
  /// Longer than the time after which the saw stops, so that the saw is coupled again, where it is, to another tool.
  static constexpr std::chrono::milliseconds kSilent{500};

  /// Returns whether the pose that a peer (1 or more) sends now is used.
  bool Accepts(std::uint64_t peer, Clock::time_point now);
  void Leave(std::uint64_t peer);

 private:
  std::uint64_t peer_ = 0;  // 0: none
  Clock::time_point at_;    // of its last pose
};

/// Frame D is the world frame: the saw moves and turns as the tool does. It is coupled where it is when the poses
/// begin, and again after each silence.
class TrackedToolDriver final : public DeviceDriver {
 public:
  explicit TrackedToolDriver(std::shared_ptr<TrackedTool> tool);

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double fraction)>&) override {}
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override {}

 private:
  std::shared_ptr<TrackedTool> tool_;
  DeviceProfile profile_;
  DriverTraits traits_;
};

/// Limits for a tool that is tracked at 10 Hz or more: without a new pose for 0.2 s it does not hold the saw any more,
/// and motion faster than 1 m/s or 10 rad/s is a fault.
ServoParams MakeTrackedToolParams();

}  // namespace kerf
