// How much the force on the device trembles, over a run of any length.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/core/high_pass.h"
#include "kerf/geometry.h"

namespace kerf {

/// Root mean square above 20 Hz, of the whole run and of the whole seconds in which the tool cut throughout. A second
/// is kept, not the run. Not for the tick.
class ForceNoise {
 public:
  /// Throws Error when `dt_s` is too long for 20 Hz.
  explicit ForceNoise(double dt_s);
  /// The force at the next deadline, N, and whether the tool cut.
  void Take(const Vec3& f_N, bool cuts);
  /// The next deadline was missed: all is as it was.
  void Hold() { Take(last_N_, cut_); }

  /// All axes together, mN. Once, at the end.
  double Finish_mN();
  /// Of the worst of those seconds; none: there was no such second.
  std::optional<double> cutting_mN() const { return cutting_mN_; }

 private:
  double dt_s_;
  std::size_t window_;
  std::array<HighPassRms, 3> whole_;
  std::array<std::vector<double>, 3> second_;
  bool all_cut_ = true;  // so far in this second
  Vec3 last_N_{0};
  bool cut_ = false;
  std::optional<double> cutting_mN_;
};

}  // namespace kerf
