// tangential_force: the force on teeth along their motion, in addition to the thrust of the force law.
#pragma once

#include <array>

#include "cut/effects/effect.h"

namespace kerf {

/// Throws kerf::Error if the law states a cutting force that is too large, compared with its thrust, for a tool in a
/// hand.
void CheckCuttingRatio(const ToothForce& law);

/// Model: F_t for each tooth is the law's cutting force or, for a law that states none, thrust / ratio. It acts against
/// the tooth's motion: on the tool along -sign(rpm) z x p_T / |z x p_T|; for an edge with a stroke along z x e times
/// its velocity. A step in which the edge moves both ways has a part of the force in either direction, and so has any
/// step of a fast stroke in a hand: the tool has no mass that would keep it from following the teeth.
///
/// In the step, the force acts as dissipation at the combined speed of the rim and the tool. Its magnitude is given: it
/// follows, with a lag, F_t of the previous steps; for a stroke on a path, it is F_t of the step itself. The convex
/// problem therefore keeps a unique solution. The work of the force on the tool is done by the spindle or lost as
/// friction, depending on the sign of the motion.
///
/// The loop thrust -> tangential force -> motion -> thrust is stable for any ratio and step. Where cutting resists the
/// motion u with M = sum k e e', the tangential forces add (1/ratio) J M u, with J a rotation by a quarter turn. A
/// change in the force therefore returns multiplied by a matrix similar to -J/ratio, with eigenvalues +-i/ratio. If
/// the lag adopts the fraction a of a change in each step, the part |1 - a +- i a/ratio| of an error remains. This is
/// below 1 as long as a < 2 / (1 + 1/ratio^2), and minimal at half of that value, which is used as the upper limit of
/// a. A straight edge that moves along itself does not bite deeper, so it needs no lag in time, only this limit. If
/// the law states the cutting force, the ratio stands for the smallest ratio of thrust to cutting force, and of
/// their changes with the bite; a law with a ratio below 0.6 is refused.
class TangentialForceEffect final : public Effect {
 public:
  TangentialForceEffect(double ratio, const EffectSetup& setup);
  /// Returns the effect of a plan. Throws Error if the plan has none.
  static const TangentialForceEffect& In(const EffectPlan& plan);
  static TangentialForceEffect& In(EffectPlan& plan);

  void Engage(const EffectStep& step, StepProblem& problem) override;
  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void Release() override;
  void Report(std::span<double> channels) const override;
  EffectCapacity capacity() const override { return {0, 2 * kSectors}; }
  std::size_t CalcMemoryBytes() const override { return sizeof(*this); }

  /// Ratio of thrust to cutting force: the parameter, or the smallest ratio of the law.
  double ratio() const { return ratio_; }

  /// Loads on the tool, means over the last tick.
  struct Figures {
    double sum_N = 0;       // sum of the magnitudes
    Vec3 pull_T_N{0};       // resultant, tool frame
    double torque_Nmm = 0;  // on the spindle about its axis, against its rotation: sum of force times distance; with a
                            // stroke on the crank: sum of force times way per angle
    double power_W = 0;     // power of the spindle for this torque
  };
  const Figures& figures() const { return figures_; }

  /// Sets the torque that the motor exerts while the spindle is stopped, positive about +z. The stopped edge transmits
  /// it to the bone. Tick-safe.
  void SetHoldingTorque(double motor_Nmm) { motor_Nmm_ = motor_Nmm; }
  /// Returns the torque that the teeth need to cut, N mm; for a stopped spindle, with the current contact forces.
  double CalcRequiredTorque() const;
  /// Way of an edge with a stroke per angle of its crank, mm: mean of the last step in which it moved.
  double lever_mm() const { return lever_mm_; }

 private:
  /// Sums over the teeth in a sector, chosen so that force, torque and power are the same as with each tooth by itself.
  struct Sector {
    double force_N = 0;
    Twist row{};         // force times the row along the tooth's motion
    double arm_Nmm = 0;  // force times distance from the spindle's axis
  };
  static constexpr int kSectors = 8;
  /// One of the two ways of a stroke; a turning edge has only one.
  struct Way {
    double share = 1;  // of the step
    double rad_per_s = 0;
    double mm_per_s = 0;  // of all teeth
    double lever_mm = 0;  // torque on the crank per force, with the sign of the way; 0: each tooth has its own
  };

  void AddUp(const EffectSolved& solved);
  double CalcForce(const ToothLoad& tooth) const;
  void SetLever(double rpm, const DriveStep* stroke);
  void Take(std::span<const ToothLoad> teeth, double fresh);
  void Fade(double fresh);
  void DropEmptySectors();
  void Add(const Vec3& p_T, const Vec3& e_T, double force_N);
  std::array<Way, 2> FindWays(double rpm, const DriveStep* stroke) const;

  bool by_law_;  // the law states the cutting force
  double ratio_;
  bool strokes_;
  double lever_mm_ = 0;
  double motor_Nmm_ = 0;  // of the stopped spindle
  double direction_ = 0;  // direction of the last rotation: 1 or -1
  double fraction_ = 1;   // active fraction of the sectors' forces: 1, or less with the spindle stopped
  Vec3 p_TC_;
  bool is_coupled_;
  bool is_loaded_ = false;  // any sector is not 0
  bool acted_ = false;      // any of the figures or their sums is not 0
  std::array<Sector, kSectors> sectors_{};
  Figures figures_;
  Figures sums_;  // weighted by time
};

}  // namespace kerf
