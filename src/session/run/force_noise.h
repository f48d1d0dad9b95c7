// Noise of the force on the device over a run of any length.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/core/high_pass.h"
#include "kerf/geometry.h"

namespace kerf {

/// Computes the root mean square of the force above 20 Hz, over the whole run and over each whole second of
/// uninterrupted cutting. Keeps only one second in memory. Not tick-safe.
class ForceNoise {
 public:
  /// Throws kerf::Error if `dt_s` is too long for 20 Hz.
  explicit ForceNoise(double dt_s);
  /// Adds the force at the next deadline, N. `cuts`: true if the tool cut.
  void Take(const Vec3& f_N, bool cuts);
  /// Call if the next deadline was missed, so that the device held the force.
  void Hold() { Take(last_N_, cut_); }

  /// Returns the noise of all axes combined, mN. Call once, at the end.
  double Finish_mN();
  /// Returns the maximum noise of the full seconds in which the tool cut throughout; none if there was no such second.
  std::optional<double> cutting_mN() const { return cutting_mN_; }

 private:
  double dt_s_;
  std::size_t window_;
  std::array<HighPassRms, 3> run_axes_;
  std::array<std::vector<double>, 3> second_axes_;
  bool all_cut_ = true;  // the tool has cut throughout this second so far
  Vec3 last_N_{0};
  bool cut_ = false;
  std::optional<double> cutting_mN_;
};

}  // namespace kerf
