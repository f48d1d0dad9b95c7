// spindle: a motor that accelerates and brakes, slows down under the load of cutting, and stalls.
#pragma once

#include "cut/effects/effect.h"
#include "cut/effects/spindle/motor.h"

namespace kerf {

class TangentialForceEffect;

/// Sets the speed that a tick uses: the motor's mean speed over the tick, under the load of the previous tick. The load
/// is the torque that the problem's friction points exert against the rotation: the teeth's tangential force, and the
/// friction of the flats.
///
/// While the spindle is stalled, the edge is a solid contact. The spindle is then held by friction and by the torque
/// that the teeth would need to cut with the current contact forces. It starts again when this torque has fallen to a
/// fraction of the motor's torque. Without this hysteresis the spindle would alternate between the two states. On a
/// prescribed path the contact forces are unknown; there it starts again only after the operator has switched it off.
class SpindleEffect final : public Effect {
 public:
  struct Params {
    Motor motor;
    bool follows = true;  // the motor's no-load speed is the speed that is set
    double restart_share = 0.7;
  };
  SpindleEffect(const Params& params, TangentialForceEffect& cutting, const EffectSetup& setup);
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

 private:
  Motor motor_;
  bool follows_;
  double restart_fraction_;
  TangentialForceEffect& cutting_;
  Twist spin_;  // motion of a tool that rotates about the spindle's axis at 1 rad/s
  bool is_coupled_;

  double w_rad_per_s_ = 0;
  bool stalled_ = false;
  double load_Nmm_ = 0;
  double hold_Nmm_ = 0;
  double dt_s_ = 0;           // of the last tick
  bool was_stopped_ = false;  // the last tick used a stopped spindle
  MotorRun run_;
  // Sums over the steps since the start of the tick, weighted by time.
  double load_Nmms_ = 0;
  double hold_Nmms_ = 0;
};

}  // namespace kerf
