// spindle: a motor that runs up and down, gives way to the load of cutting, and stalls.
#pragma once

#include "cut/effects/effect.h"
#include "cut/effects/spindle/motor.h"

namespace kerf {

class TangentialForceEffect;

/// Sets the speed with which a tick works: the motor's mean over the tick, under the load of the tick before. The load
/// is what the problem's friction points take from the turning: the teeth's tangential force, and the flats' friction.
///
/// Stalled, the edge is a solid contact. What holds the spindle then is the torque that the teeth would need to cut
/// with what presses on them, and friction. It starts again when that has fallen to a share of what the motor can turn:
/// the hysteresis, without which it would flutter. On a path nobody sees what presses: there it starts again only after
/// the operator has switched it off.
class SpindleEffect final : public Effect {
 public:
  struct Params {
    Motor motor;
    bool follows = true;  // its no-load speed is the speed that is set
    double restart_share = 0.7;
  };
  SpindleEffect(const Params& params, TangentialForceEffect& cutting, const EffectSetup& setup);
  /// That of a plan; throws Error when it has none.
  static const SpindleEffect& In(const EffectPlan& plan);

  void Begin(EffectBegin& begin) override;
  void Solved(const EffectSolved& solved) override;
  void Reset() override { load_Nmms_ = hold_Nmms_ = 0; }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override { return sizeof(*this); }

  double rpm() const;                            // at the end of the tick, signed
  bool stalled() const { return stalled_; }      // it stands still although it is switched on
  double load_Nmm() const { return load_Nmm_; }  // that the tick worked with
  double hold_Nmm() const { return hold_Nmm_; }  // what holds it while it stands still
  const MotorRun& run() const { return run_; }   // of the tick
  const Motor& motor() const { return motor_; }

 private:
  Motor motor_;
  bool follows_;
  double restart_share_;
  TangentialForceEffect& cutting_;
  Twist spin_;  // the tool's motion when it turns about the spindle's axis with 1 rad/s
  bool in_hand_;

  double w_rad_per_s_ = 0;
  bool stalled_ = false;
  double load_Nmm_ = 0;
  double hold_Nmm_ = 0;
  double dt_s_ = 0;     // of the tick
  bool stood_ = false;  // it worked with a spindle that stands still
  MotorRun run_;
  // Of the steps since the tick began, times time.
  double load_Nmms_ = 0;
  double hold_Nmms_ = 0;
};

}  // namespace kerf
