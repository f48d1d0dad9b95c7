// Velocity from positions that come in steps of an encoder.
#pragma once

#include <array>

#include "kerf/geometry.h"

namespace kerf {

/// First-order adaptive windowing (Janabi-Sharifi, Hayward and Chen 2000): the velocity is the slope from the oldest to
/// the newest sample of the longest window whose samples all lie within one quantum of that straight line. Slow motion
/// gets a long window and little noise, fast motion a short one and little delay. Each axis has a window of its own.
class AdaptiveVelocity {
 public:
  static constexpr int kMaxSamples = 32;

  /// `quantum_mm`: of the encoder, above 0. `max_samples`: of a window, 2 to kMaxSamples; held to that.
  explicit AdaptiveVelocity(double quantum_mm, int max_samples = 16);

  /// Takes the next sample, dt_s after the last (of the first it doesn't matter; above 0, else the sample is ignored).
  /// mm/s; 0 after the first sample, the last value when `p` is not finite or dt_s too short for a finite one.
  /// Tick-safe.
  Vec3 Update(const Vec3& p_mm, double dt_s);
  Vec3 velocity_mm_per_s() const { return v_; }
  void Reset();

 private:
  double CalcAxis(int axis) const;

  double quantum_;
  int max_samples_;
  std::array<Vec3, kMaxSamples> p_{};
  std::array<double, kMaxSamples> t_{};  // of each sample, s before the newest
  int count_ = 0;
  int newest_ = 0;
  Vec3 v_{0};
};

}  // namespace kerf
