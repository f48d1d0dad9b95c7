// spindle: a motor that accelerates and brakes, slows down under the load of cutting, and stalls.
#pragma once

#include "cut/effects/effect.h"
#include "cut/effects/spindle/motor.h"
#include "kerf/describe.h"

namespace kerf {

class TangentialForceEffect;

struct SpindleParams {
  double stall_torque_Nmm = 300;
  double no_load_rpm = 0;
  double inertia_gmm2 = 1000;
  double friction_Nmm = 5;
  double viscous_Nmms = 0.005;
  bool brakes = true;
  double restart_share = 0.7;
};

template <typename V>
void Describe(SpindleParams& p, V&& visit) {
  visit("stall_torque_Nmm", p.stall_torque_Nmm, Range{0.1, 1e5},
        "stall torque of the motor at the tool, at full drive");
  visit("no_load_rpm", p.no_load_rpm, Range{0, kMaxRpm},
        "speed at full drive without losses; a lower set speed means a lower drive. 0: the set speed, so that the full "
        "stall torque is available at any set speed");
  visit("inertia_gmm2", p.inertia_gmm2, Range{0.01, 1e9},
        "moment of inertia of tool, gear and rotor, as seen at the tool");
  visit("friction_Nmm", p.friction_Nmm, Range{0, 1e5}, "friction of bearings and gear, the same at all speeds");
  visit("viscous_Nmms", p.viscous_Nmms, Range{0, 1e4}, "additional friction per rad/s");
  visit("brakes", p.brakes, "the motor also brakes a spindle that turns too fast; otherwise losses slow it down");
  visit("restart_share", p.restart_share, Range{0.01, 1},
        "a stalled spindle restarts when the torque that holds it has fallen to this fraction of the motor's torque");
}

/// Sets the speed that a tick uses: the motor's mean speed over the tick, under the load of the previous tick. The load
/// is the torque that the problem's friction points exert against the rotation: the teeth's tangential force, and the
/// friction of the flats. With a stroke it is the torque on the crank: force times way per angle, mean over the tick.
///
/// While the spindle is stalled, the edge is a solid contact. The spindle is then held by friction and by the torque
/// that the teeth would need to cut with the current contact forces. It starts again when this torque has fallen to a
/// fraction of the motor's torque. Without this hysteresis the spindle would alternate between the two states. On a
/// prescribed path the contact forces are unknown; there it starts again only after the operator has switched it off.
///
/// On a path, a spindle that slows down within a turn does not give a bite of feed / speed, which has no bound: the
/// bite is the feed since a tooth last passed, when the spindle was still faster. With the teeth as the continuum that
/// they are in the contact, the mean time T since then follows T' = 1 - T passes_per_s: 1 / passes_per_s at constant
/// speed, and never longer by more than the time that has gone by. A tool in a hand yields, so that its bite stays
/// small.
class SpindleEffect final : public Effect {
 public:
  SpindleEffect(const SpindleParams& params, TangentialForceEffect& cutting, const EffectSetup& setup);
  /// Returns the effect of a plan. Throws Error if the plan has none.
  static const SpindleEffect& In(const EffectPlan& plan);

  void Begin(EffectBegin& begin) override;
  void Solved(const EffectSolved& solved) override;
  void Reset() override { load_Nmms_ = hold_Nmms_ = 0; }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override { return sizeof(*this); }

  double rpm() const;                            // at the end of the tick, signed
  bool stalled() const { return stalled_; }      // stopped although it is switched on
  double load_Nmm() const { return load_Nmm_; }  // used by the tick
  double hold_Nmm() const { return hold_Nmm_; }  // torque that holds it while it is stopped
  const MotorRun& run() const { return run_; }   // of the last tick
  const Motor& motor() const { return motor_; }
  /// Returns, for a tool on a path, 1 / mean time since a tooth last passed, in the last tick; above 0 unless stopped.
  double passes_per_s() const { return passes_per_s_; }

 private:
  void CountPasses(double rpm, double dt_s);

  Motor motor_;
  bool follows_;
  double restart_fraction_;
  TangentialForceEffect& cutting_;
  Twist spin_;  // motion of a tool that rotates about the spindle's axis at 1 rad/s
  bool is_coupled_;
  double passes_per_turn_;

  double w_rad_per_s_ = 0;
  bool stalled_ = false;
  double load_Nmm_ = 0;
  double hold_Nmm_ = 0;
  double dt_s_ = 0;           // of the last tick
  bool was_stopped_ = false;  // the last tick used a stopped spindle
  MotorRun run_;
  double since_pass_s_ = 0;  // at the end of the tick
  double passes_per_s_ = 0;
  // Sums over the steps since the start of the tick, weighted by time.
  double load_Nmms_ = 0;
  double hold_Nmms_ = 0;
};

}  // namespace kerf
