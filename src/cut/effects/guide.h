// guide: a virtual fixture. This is the interface for other code.
#pragma once

#include <array>
#include <vector>

#include "cut/effects/effect.h"

namespace kerf {

struct GuideParams {
  Vec3 point_W_mm{0};             // a point of the planned plane
  Vec3 normal_W{0, 1, 0};         // normal of the plane, of any length except 0
  double stiffness_N_per_mm = 5;  // total stiffness of its springs across the plane
  double tolerance_mm = 0.5;
  double max_force_N = 10;  // force at which it yields, across the plane and at each stop
  Vec3 depth_direction_W{0, 0, -1};
  double depth_mm = 0;        // 0: no depth stop
  double slot_length_mm = 0;  // 0: no end stops
};

/// Holds the tool to a planned plane, depth and length by one-sided springs. Passive: it never pulls the tool.
class GuideEffect final : public Effect {
 public:
  /// Throws Error if a direction has zero length, or the depth direction is not in the plane.
  GuideEffect(const GuideParams& params, const EffectSetup& setup);

  bool Holds(const EffectFlight& flight) override;
  void Engage(const EffectStep& step, StepProblem& problem) override;
  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void Reset() override { fresh_ = true; }
  void Report(std::span<double> channels) const override;
  EffectCapacity capacity() const override { return {walls_.size(), 0}; }
  std::size_t CalcMemoryBytes() const override { return sizeof(*this) + walls_.capacity() * sizeof(Wall); }

  const GuideParams& params() const { return params_; }

 private:
  /// One-sided limit for a point of the tool: the point may move along `n_W` up to `at_mm`.
  struct Wall {
    Vec3 n_W;
    Vec3 p_T;  // the point; a depth stop uses the tool's deepest point instead
    bool deepest = false;
    double min_mm;  // position of the wall in the plan, along n from the plan's point
    double stiffness_N_per_mm;
    double at_mm;           // current position: further out if the tool started, or was pushed, beyond the wall
    bool near = false;      // true if it is in the problem of this step
    std::size_t solid = 0;  // its index in the problem's solids
  };
  Vec3 FindPoint(const Wall& wall, const Pose& X_FT) const;
  double CalcPosition(const Wall& wall, const Pose& X_FT) const;
  double CalcGap(const Pose& X_FT) const;
  void Follow(const Pose& X_FT);

  GuideParams params_;
  Vec3 p_F_mm_;
  Vec3 n_W_;
  Vec3 p_TC_;
  double yield_mm_;
  double radius_mm_;
  double near_mm_;
  Vec3 depth_W_;
  bool is_disc_;
  bool fresh_ = true;
  std::vector<Wall> walls_;
  double force_N_ = 0;  // in the last tick
  bool solved_ = false;
  Pose at_;
  bool known_ = false;  // true after the first tick: at_ is valid
};

}  // namespace kerf
