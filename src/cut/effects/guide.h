// guide: a virtual fixture. What others need of it.
#pragma once

#include <array>
#include <vector>

#include "cut/effects/effect.h"

namespace kerf {

struct GuideParams {
  Vec3 point_W_mm{0};             // of the planned plane
  Vec3 normal_W{0, 1, 0};         // of any length but 0
  double stiffness_N_per_mm = 5;  // of all its springs across the plane together
  double tolerance_mm = 0.5;
  double max_force_N = 10;  // it yields beyond, across the plane; likewise each stop
  Vec3 depth_direction_W{0, 0, -1};
  double depth_mm = 0;        // 0: no stop
  double slot_length_mm = 0;  // 0: no ends
};

class GuideEffect final : public Effect {
 public:
  /// Throws Error for directions of no length, or a depth that does not lie in the plane.
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
  /// One side of something that holds a point of the tool: it may go `offset` far along `n`, and no further.
  struct Wall {
    Vec3 n_W;
    Vec3 p_T;  // the point; for a stop of depth the tool's deepest is looked for instead
    bool deepest = false;
    double least_mm;  // the wall's own place, from the plan's point along n
    double stiffness_N_per_mm;
    double at_mm;           // where it is: further out than its own place for a tool that is, or was pushed, beyond it
    bool near = false;      // in the problem of this step,
    std::size_t solid = 0;  // as this one of its solids
  };
  Vec3 FindPoint(const Wall& wall, const Pose& X_FT) const;
  double CalcWay(const Wall& wall, const Pose& X_FT) const;
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
  bool known_ = false;  // at_: a tick has been made
};

}  // namespace kerf
