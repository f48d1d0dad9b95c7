// tangential_force: the force with which teeth cut along their way, beside the thrust that the force law gives.
#pragma once

#include <array>

#include "cut/effects/effect.h"

namespace kerf {

/// F_t = thrust / ratio for each tooth, against its way: on the tool along -sign(rpm) z x p_T / |z x p_T|.
///
/// In the step it is dissipation at the speed of rim and tool together, with a force that is given: the thrust of the
/// steps before divided by the ratio, followed with a lag. The convex problem keeps one solution, and what the force
/// does to the tool is work of the spindle or lost as friction, as its motion is.
///
/// The loop thrust -> tangential force -> motion -> thrust dies out for any ratio and step: where cutting resists the
/// motion u with M = sum k e e', the tangential forces add (1/ratio) J M u, J a quarter turn, so that a change of the
/// force comes back multiplied by something similar to -J/ratio, with eigenvalues +-i/ratio. Of a lag that takes up the
/// share a in a step, |1 - a +- i a/ratio| is left: below 1 as long as a < 2 / (1 + 1/ratio^2), least at half of that,
/// which a is held to.
class TangentialForceEffect final : public Effect {
 public:
  TangentialForceEffect(double ratio, const EffectSetup& setup);
  /// That of a plan; throws Error when it has none.
  static const TangentialForceEffect& In(const EffectPlan& plan);
  static TangentialForceEffect& In(EffectPlan& plan);

  void Engage(const EffectStep& step, StepProblem& problem) override;
  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void Release() override;
  void Report(std::span<double> channels) const override;
  EffectCapacity capacity() const override { return {0, kSectors}; }
  std::size_t CalcMemoryBytes() const override { return sizeof(*this); }

  double ratio() const { return ratio_; }

  /// On the tool; means over the last tick.
  struct Figures {
    double sum_N = 0;       // of the magnitudes
    Vec3 pull_T_N{0};       // resultant, tool frame
    double torque_Nmm = 0;  // on the spindle about its axis, against its turning: sum of force times distance
    double power_W = 0;     // that the spindle gives for it
  };
  const Figures& figures() const { return figures_; }

  /// The spindle stands still, and its motor turns against what holds it: signed as the speed. The stopped edge keeps
  /// the pull of that. Tick-safe.
  void SetHeld(double motor_Nmm) { motor_Nmm_ = motor_Nmm; }
  /// The torque that the teeth need to cut, or, standing still, would need with what presses on them, N mm.
  double CalcNeeded() const;

 private:
  /// Where teeth are gathered. Sums, so that force, torque and power are those of each tooth by itself.
  struct Sector {
    double force_N = 0;
    Twist row{};         // force times the row along the tooth's way
    double arm_Nmm = 0;  // force times distance from the spindle's axis
  };
  static constexpr int kSectors = 8;

  void AddUp(const EffectSolved& solved);
  void Add(const Vec3& p_T, double force_N);
  double CalcSlipSpeed(double rpm) const;

  double ratio_;
  double motor_Nmm_ = 0;  // with the spindle stopped
  double way_ = 0;        // of the last turning: 1, -1
  double share_ = 1;      // of the sectors' forces that acts: all, but with the spindle stopped
  Vec3 p_TC_;
  bool in_hand_;
  bool bears_ = false;  // any sector is not 0
  bool acted_ = false;  // any of the figures or their sums is not 0
  std::array<Sector, kSectors> sectors_{};
  Figures figures_;
  Figures sums_;  // times time
};

}  // namespace kerf
