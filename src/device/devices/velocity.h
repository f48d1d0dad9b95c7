// Velocity from positions that come in steps of an encoder.
#pragma once

#include <array>

#include "kerf/geometry.h"

namespace kerf {

/// First-order adaptive windowing with the best fit (Janabi-Sharifi, Hayward and Chen 2000): the velocity is the slope
/// of least squares over the longest window whose samples all lie within one quantum of the straight line between its
/// ends (from end to end it would be as noisy as two samples: a hand on the border of two counts feels that). Slow
/// motion gets a long window and little noise, fast motion a short one and little delay. Each axis has a window of its
/// own.
///
/// A sample that is the last one again, while the handle moves by more than the encoder can miss, is a device that is
/// slower than the loop: the velocity is held for up to kLongestRepeat_s, and after that is none. When it comes back,
/// or after a step that no hand makes, the window begins anew, at velocity 0.
class AdaptiveVelocity {
 public:
  static constexpr int kMaxSamples = 32;
  static constexpr double kLongestRepeat_s = 0.005;
  static constexpr double kMostAcceleration_mm_per_s2 = 3e5;  // 30 g: no hand
  static constexpr double kLeastStop_mm_per_s2 = 1e4;         // 1 g: a handle that stops as suddenly has not stopped

  /// `quantum_mm`: of the encoder, above 0. `max_samples`: of a window, 2 to kMaxSamples; held to that.
  /// `reach_mm`: for angles (rad), the radius at which one is taken for a way.
  explicit AdaptiveVelocity(double quantum_mm, int max_samples = 16, double reach_mm = 1);

  /// Takes the next sample, dt_s after the last (of the first it doesn't matter; above 0 and finite, else the sample is
  /// ignored). mm/s; 0 after the first sample, the last value when `p` is not finite or dt_s too short for a finite
  /// one. Tick-safe.
  Vec3 Update(const Vec3& p_mm, double dt_s);
  Vec3 velocity_mm_per_s() const { return v_; }
  void Reset();

 private:
  double CalcAxis(int axis) const;

  double quantum_;
  int max_samples_;
  double reach_;
  std::array<Vec3, kMaxSamples> p_{};
  std::array<double, kMaxSamples> t_{};  // of each sample, s before the newest
  int count_ = 0;
  int newest_ = 0;
  double repeated_s_ = 0;  // since the newest sample first came
  Vec3 v_{0};
};

}  // namespace kerf
