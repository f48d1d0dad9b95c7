// Follows a turn of the saw to a pose, which takes a while and which bone can stop.
#pragma once

#include <algorithm>
#include <cmath>

#include "kerf/geometry.h"

namespace kerf {

class SawTurn {
 public:
  enum class State { kNone, kTurning, kDone, kStuck, kInterrupted };
  static constexpr double kThere_mm = 0.3;  // from the goal, at the saw's rim
  static constexpr double kNear_mm = 1;     // from the goal's plane: where friction or bone may leave the saw
  static constexpr double kProgress_mm = 0.1;
  static constexpr double kPatience_s = 1.5;  // without progress

  /// `reach_mm`: radius of the saw.
  void Begin(const Pose& X_goal, double reach_mm) {
    X_goal_ = X_goal;
    reach_mm_ = reach_mm;
    best_mm_ = 1e9;
    waited_s_ = 0;
    turning_ = true;
  }
  bool is_turning() const { return turning_; }

  /// Returns how far the saw's rim is from the plane of the goal's blade, at most; 0 if the blade lies in that plane.
  static double CalcBeside(const Pose& X_WT, const Pose& X_goal, double reach_mm) {
    const Vec3 normal_W = X_goal.Vector({0, 0, 1});
    const double cosine = std::min(1.0, std::abs(glm::dot(X_WT.Vector({0, 0, 1}), normal_W)));
    return std::abs(glm::dot(X_WT.p_AB - X_goal.p_AB, normal_W)) + reach_mm * std::acos(cosine);
  }

  /// Call once per frame. `goes_on`: the saw is still asked to go to the goal. Returns kTurning until the turn ends,
  /// then once how it ended, and kNone after that. A saw that stops on its way but lies in the goal's plane is done.
  State Update(double dt_s, const Pose& X_WT, bool goes_on) {
    if (!turning_) return State::kNone;
    if (!goes_on) return End(State::kInterrupted);
    const double cosine = std::min(1.0, std::abs(glm::dot(X_WT.R_AB, X_goal_.R_AB)));
    const double left_mm = glm::distance(X_WT.p_AB, X_goal_.p_AB) + reach_mm_ * 2 * std::acos(cosine);
    if (left_mm < kThere_mm) return End(State::kDone);
    waited_s_ = left_mm < best_mm_ - kProgress_mm ? 0 : waited_s_ + dt_s;
    if (waited_s_ == 0) best_mm_ = left_mm;
    if (waited_s_ < kPatience_s) return State::kTurning;
    return End(CalcBeside(X_WT, X_goal_, reach_mm_) < kNear_mm ? State::kDone : State::kStuck);
  }

 private:
  State End(State how) {
    turning_ = false;
    return how;
  }

  Pose X_goal_;
  double reach_mm_ = 0;
  double best_mm_ = 0;  // distance from the goal at the last progress
  double waited_s_ = 0;
  bool turning_ = false;
};

}  // namespace kerf
