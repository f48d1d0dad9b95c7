// guide: a virtual fixture. This is the interface for other code.
#pragma once

#include <array>
#include <vector>

#include "cut/effects/effect.h"
#include "kerf/describe.h"

namespace kerf {

struct GuideParams {
  Vec3 point_W_mm{0};
  Vec3 normal_W{0, 1, 0};
  double stiffness_N_per_mm = 5;
  double tolerance_mm = 0.5;
  double max_force_N = 10;
  Vec3 depth_direction_W{0, 0, -1};
  double depth_mm = 0;
  double slot_length_mm = 0;
};

template <typename V>
void Describe(GuideParams& p, V&& visit) {
  visit("point_mm", p.point_W_mm, kCoordinateRange_mm,
        "point of the planned plane, world frame; depth and slot are measured from it");
  visit("normal", p.normal_W, kDirectionRange, "normal of the plane, world frame; any length except 0");
  visit("stiffness_N_per_mm", p.stiffness_N_per_mm, Range{0.01, 1000},
        "stiffness that holds the tool on the plane and at each stop");
  visit("tolerance_mm", p.tolerance_mm, Range{0, 100},
        "distance from the plane within which each point of a disc's rim (for a ball: its centre) is free");
  visit("max_force_N", p.max_force_N, Range{0.1, 1000},
        "force above which the guide gives way, across the plane or at a stop; within a step it may be exceeded by the "
        "stiffness times the step's motion");
  visit("depth_direction", p.depth_direction_W, kDirectionRange,
        "direction into the bone, in the plane; any length except 0");
  visit("depth_mm", p.depth_mm, Range{0, 1000},
        "depth below point_mm at which a stop holds the tool's deepest point, by a spring of stiffness_N_per_mm; 0: no "
        "stop");
  visit("slot_length_mm", p.slot_length_mm, Range{0, 1000},
        "length of the slot: the tool's centre stays within half of it on either side of point_mm, perpendicular to "
        "the depth; 0: no ends");
}

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
  static constexpr std::size_t kForceChannel = 3;  // index of force_N among its channels

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
  Vec3 FindDeepestOfTool(const Vec3& n_T) const;
  Vec3 FindPoint(const Wall& wall, const Pose& X_FT) const;
  double CalcPosition(const Wall& wall, const Pose& X_FT) const;
  double CalcGap(const Pose& X_FT) const;
  void Follow(const Pose& X_FT);

  GuideParams params_;
  Tool tool_;
  Vec3 p_F_mm_;
  Vec3 n_W_;
  Vec3 p_TC_;
  double yield_mm_;
  ConvexOutline outline_;  // of a blade that is not round
  double half_stroke_mm_;
  double radius_mm_;
  double near_mm_;
  Vec3 depth_W_;
  bool is_blade_;
  double top_mm_;  // height of a solid of revolution; 0: another tool
  bool fresh_ = true;
  std::vector<Wall> walls_;
  double force_N_ = 0;  // in the last tick
  bool solved_ = false;
  Pose at_;
  bool known_ = false;  // true after the first tick: at_ is valid
};

}  // namespace kerf
