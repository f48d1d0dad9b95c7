// Estimates a velocity from positions that are quantised by an encoder.
#pragma once

#include <array>

#include "kerf/geometry.h"

namespace kerf {

/// First-order adaptive windowing with best fit (Janabi-Sharifi, Hayward and Chen 2000). The velocity is the
/// least-squares slope over the longest window whose samples all lie within one quantum of the straight line between
/// its ends. (The end-to-end slope would be as noisy as that of two samples; a hand at the border between two counts
/// would feel the noise.) Slow motion gets a long window and little noise, fast motion a short one and little delay.
/// Each axis has a separate window.
///
/// If a sample repeats the last one although the handle moves too fast for the encoder to miss the motion, the device
/// is slower than the loop: the velocity is held for up to kLongestRepeat_s and is then 0. When a new sample arrives
/// after that, or after a step that is too large for a hand, a new window begins with velocity 0.
class AdaptiveVelocity {
 public:
  static constexpr int kMaxSamples = 32;
  static constexpr double kLongestRepeat_s = 0.005;
  static constexpr double kMaxAcceleration_mm_per_s2 = 3e5;  // 30 g: faster than any hand
  static constexpr double kMinStop_mm_per_s2 = 1e4;          // 1 g: a handle that seems to stop faster has not stopped

  /// `quantum_mm`: resolution of the encoder, above 0. `max_samples`: maximum number of samples in a window, clamped to
  /// 2 to kMaxSamples. `reach_mm`: for angles (rad), the radius that converts an angle to a distance.
  explicit AdaptiveVelocity(double quantum_mm, int max_samples = 16, double reach_mm = 1);

  /// Takes the next sample, dt_s after the last one, and returns the velocity in mm/s. dt_s is ignored for the first
  /// sample; otherwise the sample is ignored unless dt_s is finite and above 0. Returns 0 after the first sample, and
  /// the last value if `p` is not finite or dt_s is too short for a finite result. Tick-safe.
  Vec3 Update(const Vec3& p_mm, double dt_s);
  /// The last velocity: mm/s, or rad/s if the samples are angles.
  Vec3 velocity() const { return v_; }
  void Reset();

 private:
  double CalcAxis(int axis) const;

  double quantum_;
  int max_samples_;
  double reach_;
  std::array<Vec3, kMaxSamples> p_{};
  std::array<double, kMaxSamples> t_{};  // time of each sample, s before the newest
  int count_ = 0;
  int newest_ = 0;
  double repeated_s_ = 0;  // time since the newest sample first arrived
  Vec3 v_{0};
};

}  // namespace kerf
