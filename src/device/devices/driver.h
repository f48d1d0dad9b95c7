// A haptic device in its own terms: what it is told and what it tells, round by round. Drivers speak a device's
// protocol over a transport; they know nothing of the simulation, of threads or of time.
//
// Frame D, the device's: right-handed, x to the user's right, y up, z towards the user; its origin is the middle of the
// workspace. mm, N, rad.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "device/devices/device.h"
#include "kerf/geometry.h"

namespace kerf {

/// What kind of motion a device tells.
enum class DriverMotion : std::uint8_t {
  kPosition,    // of the handle, and with DriverTraits::senses_orientation its turning
  kDeflection,  // of a sprung cap, from which speeds are made: no force
};

struct DriverTraits {
  DriverMotion motion = DriverMotion::kPosition;
  bool makes_force = true;
  bool senses_orientation = false;
  bool homes = false;  // tells no true position before its handle has been moved as `homing` says
  /// To the user: "pull the grip all the way out, then push it in". Of one that does not home: how it must lie, or have
  /// lain, for its zero to be true, which it can't tell.
  std::string homing;
  double rate_hz = 1000;             // of rounds, at most
  int timeout_ms = 10;               // of a round: longer, and it is one without an answer
  std::vector<std::string> buttons;  // names, of bit 0 on
};

/// What the device is to make, frame D. All zero is always safe.
struct DriverCommand {
  Vec3 f_D_N{0};
  Vec3 tau_D_Nmm{0};
  /// For devices with a servo loop of their own: near p_D_mm the force is f_D_N - stiffness (x - p_D_mm), along f_D_N
  /// only, as long as it does not change its sign; and - damping * velocity. Others take f_D_N as it is.
  Vec3 p_D_mm{0};
  double stiffness_N_per_mm = 0;
  double damping_Ns_per_mm = 0;
  bool engaged = false;  // the force is on: for lamps
};

struct DriverSample {
  Pose X_DH;  // handle; orientation as of frame D where it is not sensed
  bool homed = true;
  std::uint32_t buttons = 0;
  std::array<double, 6> deflection{};  // kDeflection: x, y, z, about x, y, z; -1 to 1
};

enum class RoundEnd : std::uint8_t {
  kSample,     // the command has gone out whole, and an answer came
  kNoAnswer,   // in time, or the command did not go out; the next may come
  kBadAnswer,  // something came that can't be right: dropped
  kGone,       // unplugged, closed: it must be opened anew
};

/// Between Start() and Stop(): one round after the other. One thread at a time; none is for the tick.
class DeviceDriver {
 public:
  DeviceDriver() = default;
  DeviceDriver(const DeviceDriver&) = delete;
  DeviceDriver& operator=(const DeviceDriver&) = delete;
  virtual ~DeviceDriver() = default;

  virtual const DeviceProfile& profile() const = 0;
  virtual const DriverTraits& traits() const = 0;
  /// Makes the device ready to exchange: modes, firmware. May take seconds; `show` gets what is done and 0 to 1, and
  /// ends it by false. Throws Error with what the user can do about it.
  virtual void Start(const std::function<bool(const std::string& doing, double share)>& show) = 0;
  /// One round: the command out, an answer in. Waits at most traits().timeout_ms. No allocation. A command that is not
  /// finite is taken as zero; one beyond the device's peak is shortened with its direction kept. `sample` changes only
  /// with kSample.
  virtual RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept = 0;
  /// No force, as far as the device still hears it. Any number of times.
  virtual void Stop() noexcept = 0;
};

}  // namespace kerf
