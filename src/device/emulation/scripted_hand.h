// Hand on the handle of an emulated device: follows a prescribed path, yields to the motors' force, presses buttons and
// homes the device as a user would.
#pragma once

#include <cstdint>
#include <vector>

#include "device/devices/hand.h"
#include "device/devices/simulated_device.h"
#include "device/emulation/mechanism.h"

namespace kerf {

enum class ScriptedPath : std::uint8_t {
  kStill,   // in the middle of the workspace
  kCircle,  // around the middle, in the x-y plane
  kLine,    // back and forth along x
};

struct HandPress {
  double from_s = 0;  // path time at which the press begins
  double to_s = 0;
  std::uint32_t buttons = 0;
};

struct ScriptedHandOptions {
  ScriptedPath path = ScriptedPath::kStill;
  double radius_mm = 15;
  double period_s = 2;
  std::vector<HandPress> presses{};
  double home_out_mm = 42;  // position along z, towards the user, to which the hand moves for homing
  double home_in_mm = -38;  // the same away from the user
};

template <typename V>
void Describe(ScriptedHandOptions& p, V&& visit) {
  visit("radius_mm", p.radius_mm, Range{1e-3, 1000}, "radius of the circle, half length of the line");
  visit("period_s", p.period_s, Range{1e-3, 1000}, "duration of a turn");
}

/// Point mass on the hand's spring and damper (devices/simulated_device.h) in frame D. Path time starts at Begin()
/// and is stopped while the hand homes the device.
class ScriptedHand final : public Mechanism {
 public:
  /// Throws kerf::Error if an option is out of range.
  ScriptedHand(const DeviceProfile& profile, const HandModel& hand, const ScriptedHandOptions& options);

  /// Starts moving the handle; the path grows from zero within a second.
  void Begin() { begun_ = true; }
  /// Moves all the way out, all the way in, and back, which takes 3 s. Does nothing if this is already in progress.
  void Home();
  bool begun() const { return begun_; }
  bool homing() const { return home_s_ >= 0; }
  double path_s() const { return path_s_; }
  Vec3 f_D_N() const { return device_.force_N(); }

  void Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) override;
  Pose handle() const override { return X_DH_; }
  std::uint32_t buttons() const override;

 private:
  Vec3 CalcWanted() const;

  ScriptedHandOptions options_;
  SimulatedDevice device_;
  bool begun_ = false;
  double path_s_ = 0;
  double home_s_ = -1;  // time since the homing motion began; below 0: not homing
  Pose X_DH_;
};

}  // namespace kerf
