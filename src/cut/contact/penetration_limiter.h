// State of contact that is kept from step to step, so that contact holds the tool but never throws it out.
#pragma once

#include <algorithm>
#include <vector>

namespace kerf {

/// Depth of each contact point of the tool in the bone, as the deflection of the spring that holds the point.
///
/// A point may be found to lie deeper than its spring was deflected, because the bone is uneven, the tool was set down
/// inside bone, or the grid blurs a corner. Pushing the point out at once would create energy. At the start of a step,
/// a spring is therefore deflected at most as far as at the end of the last step. If earlier losses cover the energy
/// for it (see the energy balance of the coupled tick), the distance covered at `kSpeed_mm_per_s` is added.
class PenetrationLimiter {
 public:
  static constexpr double kSpeed_mm_per_s = 2;

  explicit PenetrationLimiter(std::size_t points) : known_mm_(points, 0.0) {}

  /// Returns the depth that the spring of point `i` may have at the start of a step, mm. Tick-safe.
  double Limit(int i, double found_mm, double step_s, bool may_rise) const {
    const double max_mm = known_mm_[i] + (may_rise ? kSpeed_mm_per_s * step_s : 0);
    return std::min(found_mm, max_mm);
  }
  void set_known_mm(int i, double depth_mm) { known_mm_[i] = depth_mm; }
  void Ease(double fraction) {
    for (double& depth_mm : known_mm_) depth_mm *= fraction;
  }
  void Forget() { std::fill(known_mm_.begin(), known_mm_.end(), 0.0); }
  std::size_t size() const { return known_mm_.size(); }

 private:
  std::vector<double> known_mm_;
};

}  // namespace kerf
