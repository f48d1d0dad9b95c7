// Driver of a haptic device: exchanges commands and samples with it, round by round. A driver implements the device's
// protocol over a transport. It does not depend on the simulation, on threads or on time.
//
// Frame D of the device is right-handed: x points to the user's right, y up and z towards the user. Its origin is in
// the middle of the workspace. Units: mm, N, rad.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kerf/device.h"
#include "kerf/geometry.h"

namespace kerf {

/// Kind of motion that a device reports.
enum class DriverMotion : std::uint8_t {
  kPosition,    // position of the handle, and its orientation if DriverTraits::senses_orientation is set
  kDeflection,  // deflection of a spring-centred cap, from which speeds are computed; no force
};

struct DriverTraits {
  DriverMotion motion = DriverMotion::kPosition;
  bool makes_force = true;
  bool senses_orientation = false;
  bool homes = false;  // reports no valid position until its handle has been moved as `homing` describes
  /// Instruction to the user, such as "pull the grip all the way out, then push it in". For a device that does not
  /// home, it describes the pose that the handle must have now, or must have had at power-on, for the device's zero to
  /// be valid; the device cannot check this.
  std::string homing;
  double rate_hz = 1000;             // maximum rate of rounds
  int timeout_ms = 10;               // maximum duration of a round; after that, the round counts as unanswered
  std::vector<std::string> buttons;  // names, starting with bit 0

  /// True if the tool follows the handle; false if it moves at a speed.
  bool holds_tool() const { return motion == DriverMotion::kPosition; }
};

/// Limits of a driver that reaches its device through a port of a program.
inline constexpr Range kPortRange{1, 65535};
inline constexpr Range kTimeoutRange_ms{1, 1000};
template <typename Options, typename V>
void DescribeLink(Options& p, V&& visit) {
  visit("port", p.port, kPortRange, "port of the program");
  visit("timeout_ms", p.timeout_ms, kTimeoutRange_ms, "timeout of a round");
  visit("start_timeout_ms", p.start_timeout_ms, Range{1, 60'000}, "timeout of each step of the start");
}

/// Requested output of the device in frame D. Zero is always safe.
struct DriverCommand {
  Vec3 f_D_N{0};
  Vec3 tau_D_Nmm{0};
  /// The following three fields are for devices with their own servo loop. Near p_D_mm, the force of such a device is
  /// f_D_N minus stiffness * (x - p_D_mm) minus damping * velocity. The stiffness term acts only along f_D_N and never
  /// reverses the force. Other devices output f_D_N unchanged.
  Vec3 p_D_mm{0};
  double stiffness_N_per_mm = 0;
  double damping_Ns_per_mm = 0;
  bool engaged = false;  // true: the force is enabled; used for indicator lamps
};

struct DriverSample {
  Pose X_DH;  // pose of the handle; without a sensed orientation, the axes are those of frame D
  bool homed = true;
  std::uint32_t buttons = 0;
  std::array<double, 6> deflection{};  // kDeflection: translation along x, y, z and rotation about x, y, z; -1 to 1
};

enum class RoundEnd : std::uint8_t {
  kSample,     // the command was sent completely and an answer was received
  kNoAnswer,   // no answer in time, or the command was not sent; the next round may succeed
  kBadAnswer,  // an invalid answer was received and dropped
  kGone,       // unplugged or closed: the device must be opened again
};

/// Interface of a driver. Between Start() and Stop(), the caller runs one round after another. A driver is used by one
/// thread at a time, and not in the tick.
class DeviceDriver {
 public:
  DeviceDriver() = default;
  DeviceDriver(const DeviceDriver&) = delete;
  DeviceDriver& operator=(const DeviceDriver&) = delete;
  virtual ~DeviceDriver() = default;

  virtual const DeviceProfile& profile() const = 0;
  virtual const DriverTraits& traits() const = 0;
  /// Prepares the device for rounds: sets modes, loads firmware. May take seconds. `show` receives the current step and
  /// the progress (0 to 1), and cancels by returning false. Throws a kerf::Error that states what the user can do.
  virtual void Start(const std::function<bool(const std::string& doing, double fraction)>& show) = 0;
  /// Runs one round: sends the command and receives an answer, waiting at most traits().timeout_ms. Does not allocate.
  /// A command that is not finite is replaced by zero; a command beyond the device's peak is reduced to it, keeping its
  /// direction. `sample` changes only if the result is kSample.
  virtual RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept = 0;
  /// Commands zero force if the device can still receive it. May be called repeatedly.
  virtual void Stop() noexcept = 0;
};

}  // namespace kerf
