// A hand on the handle of an emulated device: it goes a way of its own, gives way to the motors' force, presses buttons
// and homes the device as its user would.
#pragma once

#include <cstdint>
#include <vector>

#include "device/devices/hand.h"
#include "device/devices/simulated_device.h"
#include "device/emulation/mechanism.h"

namespace kerf {

enum class HandWay : std::uint8_t {
  kStill,   // in the middle of the workspace
  kCircle,  // about it, in the plane of x and y
  kLine,    // to and fro along x
};

struct HandPress {
  double from_s = 0;  // of the way's time
  double to_s = 0;
  std::uint32_t buttons = 0;
};

struct ScriptedHandOptions {
  HandWay way = HandWay::kStill;
  double radius_mm = 15;  // of the circle, half of the line; above 0
  double period_s = 2;    // above 0
  std::vector<HandPress> presses{};
  double home_out_mm = 42;  // along z, towards the user, and away from them
  double home_in_mm = -38;
};

/// A point mass on the hand's spring and damper (devices/simulated_device.h) within frame D. The way's time runs from
/// Begin() on and stands while the hand homes.
class ScriptedHand final : public Mechanism {
 public:
  /// Throws Error when an option is out of range.
  ScriptedHand(const DeviceProfile& profile, const HandModel& hand, const ScriptedHandOptions& options);

  /// The handle is taken out of rest; the way swells from nothing within a second.
  void Begin() { begun_ = true; }
  /// All the way out, all the way in, back: 3 s. Nothing when it is at it.
  void Home();
  bool begun() const { return begun_; }
  bool homing() const { return home_s_ >= 0; }
  double way_s() const { return way_s_; }
  Vec3 f_D_N() const { return device_.force_N(); }

  void Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) override;
  Pose handle() const override { return X_DH_; }
  std::uint32_t buttons() const override;

 private:
  Vec3 CalcWanted() const;

  ScriptedHandOptions options_;
  SimulatedDevice device_;
  bool begun_ = false;
  double way_s_ = 0;
  double home_s_ = -1;  // since homing began; below 0: it does not home
  Pose X_DH_;
};

}  // namespace kerf
